// SPDX-License-Identifier: Apache-2.0
// Lines, words and numbers of text formats; independent of the locale.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <system_error>

namespace spheretree::formats {

inline bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && isBlank(text.front())) text.remove_prefix(1);
  while (!text.empty() && isBlank(text.back())) text.remove_suffix(1);
  return text;
}

/// Removes the next word from the front of `line` and returns it; empty at its end.
inline std::string_view takeWord(std::string_view& line) {
  std::size_t first = 0;
  while (first < line.size() && isBlank(line[first])) ++first;
  std::size_t last = first;
  while (last < line.size() && !isBlank(line[last])) ++last;
  const std::string_view word = line.substr(first, last - first);
  line.remove_prefix(last);
  return word;
}

/// Splits text at LF, CRLF or a lone CR. Zero bytes and Ctrl-Z at its end, as old programs wrote them, are ignored.
class Lines {
 public:
  explicit Lines(std::span<const char> text, std::size_t first_number = 1) : text_(text.data(), text.size()), number_(first_number - 1) {
    while (!text_.empty() && (text_.back() == '\0' || text_.back() == '\x1a')) text_.remove_suffix(1);
    // A lone CR ends lines only in files without any LF (old Macintosh); deciding this once makes later searches cheap.
    end_ = std::memchr(text.data() ? text.data() : "", '\n', text.size()) ? '\n' : '\r';
  }
  /// False at the end. The line has no line end.
  bool next(std::string_view& line) {
    if (at_ >= text_.size()) return false;
    const void* found = std::memchr(text_.data() + at_, end_, text_.size() - at_);
    const std::size_t last = found ? static_cast<std::size_t>(static_cast<const char*>(found) - text_.data()) : text_.size();
    line = text_.substr(at_, last - at_);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    at_ = last + 1;
    ++number_;
    return true;
  }
  std::size_t number() const { return number_; }                                         // of the last returned line, from 1
  std::size_t remaining() const { return at_ < text_.size() ? text_.size() - at_ : 0; }  // [bytes]

 private:
  std::string_view text_;
  std::size_t at_ = 0, number_;
  char end_;
};

enum class NumberFault { None, Malformed, OutOfRange };

/// Whether the decimal number `word` lies below 1 in magnitude: where its first digit other than 0 stands.
inline bool isBelowOne(std::string_view word) {
  const std::size_t e = std::min(word.find_first_of("eE"), word.size()), point = std::min(word.substr(0, e).find('.'), e);
  const std::size_t digit = word.substr(0, e).find_first_of("123456789");
  if (digit == std::string_view::npos) return true;
  std::int64_t exponent = 0;
  std::string_view text = word.substr(std::min(e + 1, word.size()));
  if (text.starts_with('+')) text.remove_prefix(1);
  if (const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), exponent); error == std::errc::result_out_of_range)
    return text.starts_with('-');
  return static_cast<std::int64_t>(point) - static_cast<std::int64_t>(digit) - (point > digit) + exponent < 0;
}

/// Also reads a leading '+', "nan", "inf", and what C programs on Windows wrote for these, such as "1.#QNAN" and
/// "-1.#IND00". A number too small for double precision is 0.
inline NumberFault parseDouble(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  if (const std::size_t sign = word.starts_with('-'); word.substr(sign).starts_with("1.#")) {
    value = word.substr(sign + 3).starts_with("INF") ? std::numeric_limits<double>::infinity() : std::numeric_limits<double>::quiet_NaN();
    return NumberFault::None;
  }
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error == std::errc::invalid_argument || end != word.data() + word.size()) return NumberFault::Malformed;
  if (error == std::errc()) return NumberFault::None;
  if (!isBelowOne(word)) return NumberFault::OutOfRange;
  value = 0;
  return NumberFault::None;
}

inline bool parseInteger(std::string_view word, std::int64_t& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

/// For messages: the shortest decimal that reads back as `value`.
inline std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// For messages: in quotes, at most 40 characters, control characters as '?'.
inline std::string inQuotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text.substr(0, 40)) result += static_cast<unsigned char>(c) < 32 || c == 127 ? '?' : c;
  return result + (text.size() > 40 ? "...\"" : "\"");
}

}  // namespace spheretree::formats
