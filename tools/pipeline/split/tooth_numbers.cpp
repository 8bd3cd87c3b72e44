// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/split/tooth_numbers.h"

#include <cctype>

namespace spheretree::pipeline {
namespace {

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

/// Visits the words of letters and digits in a name.
template <class Visit>
void forWords(const std::string& text, Visit&& visit) {
  std::string word;
  for (const char c : text + " ") {
    if (std::isalnum(static_cast<unsigned char>(c))) {
      word += c;
      continue;
    }
    if (!word.empty()) visit(word);
    word.clear();
  }
}

}  // namespace

bool isFdi(std::int32_t number) {
  const std::int32_t quadrant = number / 10, tooth = number % 10;
  return tooth >= 1 && ((quadrant >= 1 && quadrant <= 4 && tooth <= 8) || (quadrant >= 5 && quadrant <= 8 && tooth <= 5));
}

bool isUpperFdi(std::int32_t number) {
  const std::int32_t quadrant = number / 10;
  return isFdi(number) && (quadrant == 1 || quadrant == 2 || quadrant == 5 || quadrant == 6);
}

std::optional<std::int32_t> fdiOfUniversal(std::int32_t n) {
  if (n >= 1 && n <= 8) return 19 - n;    // 18 .. 11
  if (n >= 9 && n <= 16) return 12 + n;   // 21 .. 28
  if (n >= 17 && n <= 24) return 55 - n;  // 38 .. 31
  if (n >= 25 && n <= 32) return 16 + n;  // 41 .. 48
  return std::nullopt;
}

std::optional<std::int32_t> fdiOfPalmer(std::string_view text) {
  std::string word;
  for (const char c : lower(text))
    if (c != '-' && c != '_' && c != ' ') word += c;
  if (word.size() != 3 || (word[0] != 'u' && word[0] != 'l') || (word[1] != 'r' && word[1] != 'l')) return std::nullopt;
  const bool upper = word[0] == 'u', right = word[1] == 'r';
  const std::int32_t quadrant = upper ? (right ? 1 : 2) : (right ? 4 : 3);
  if (word[2] >= '1' && word[2] <= '8') return 10 * quadrant + (word[2] - '0');
  if (word[2] >= 'a' && word[2] <= 'e') return 10 * (quadrant + 4) + (word[2] - 'a' + 1);
  return std::nullopt;
}

std::optional<std::int32_t> labelOfName(std::string_view name, const std::string& numbering) {
  const std::string text = lower(name);
  for (const char* gum : {"gum", "gingiva", "soft"})
    if (text.find(gum) != std::string::npos) return 0;
  std::optional<std::int32_t> found;
  if (numbering == "palmer") {
    forWords(text, [&](const std::string& word) {
      if (!found) found = fdiOfPalmer(word);
    });
    return found;
  }
  std::string digits;
  for (const char c : text + " ") {
    if (std::isdigit(static_cast<unsigned char>(c))) {
      digits += c;
      continue;
    }
    if (!found && !digits.empty() && digits.size() <= 3) found = std::stoi(digits);
    digits.clear();
  }
  if (found && numbering == "universal") return fdiOfUniversal(*found);
  return found;
}

}  // namespace spheretree::pipeline
