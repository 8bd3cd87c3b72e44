// SPDX-License-Identifier: GPL-3.0-or-later
#include "terminal.h"

#include <algorithm>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <mutex>

#include "system_calls.h"

namespace spheretree::tool {
namespace {

std::mutex line_mutex;
std::size_t drawn_columns = 0;  // length of the visible progress line

void clearLocked() {
  if (drawn_columns == 0) return;
  const int columns = terminalColumns();  // the window may have become narrower
  const int blanks = columns > 0 ? std::min(static_cast<int>(drawn_columns), columns - 1) : static_cast<int>(drawn_columns);
  std::fprintf(stderr, "\r%*s\r", blanks, "");
  std::fflush(stderr);
  drawn_columns = 0;
}

}  // namespace

std::string plainText(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    // U+0080 to U+009F are also control characters: C2 80 to C2 9F in UTF-8.
    const bool is_c1 = c == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) >= 0x80 &&
                       static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (c >= 32 && c != 127 && !is_c1) {
      plain += text[i];
      continue;
    }
    const unsigned char code = is_c1 ? static_cast<unsigned char>(text[++i]) : c;
    char escaped[8];
    std::snprintf(escaped, sizeof escaped, "\\x%02x", static_cast<unsigned>(code));
    plain += code == '\n' ? "\\n" : code == '\t' ? "\\t" : escaped;
  }
  return plain;
}

std::string counted(std::size_t count, std::string_view what, std::string_view plural) {
  if (count != 1 && !plural.empty()) return std::to_string(count) + " " + std::string(plural);
  return std::to_string(count) + " " + std::string(what) + (count == 1 ? "" : "s");
}

void printResult(const char* format, ...) {
  clearProgressLine();
  std::va_list arguments;
  va_start(arguments, format);
  std::vprintf(format, arguments);
  va_end(arguments);
}

void writeResult(std::string_view text) {
  clearProgressLine();
  std::fwrite(text.data(), 1, text.size(), stdout);
}

void say(std::string_view line) {
  std::fflush(stdout);  // keeps the order of the outputs
  const std::lock_guard lock(line_mutex);
  clearLocked();
  std::fprintf(stderr, "%s\n", plainText(line).c_str());
}

int terminalColumns() {
  if (!isTerminal(Stream::Error)) return 0;
  if (const char* term = std::getenv("TERM"); term && std::string_view(term) == "dumb") return 0;
  const int width = terminalWidth();
  return width > 0 ? width : 80;
}

void drawProgressLine(std::string_view text, int columns) {
  const std::lock_guard lock(line_mutex);
  // The last column stays empty: a character there makes some terminals begin a new line.
  const std::size_t length = std::min(text.size(), static_cast<std::size_t>(std::max(1, columns - 1)));
  const std::size_t blanks = std::min(drawn_columns, static_cast<std::size_t>(std::max(1, columns - 1)));
  std::fprintf(stderr, "\r%.*s%*s", static_cast<int>(length), text.data(), static_cast<int>(blanks > length ? blanks - length : 0), "");
  std::fflush(stderr);
  drawn_columns = std::max(length, blanks);
}

void clearProgressLine() {
  const std::lock_guard lock(line_mutex);
  clearLocked();
}

}  // namespace spheretree::tool
