// SPDX-License-Identifier: Apache-2.0
// Reads JSON in the servo loop: no allocation, bounded depth, and lenient, since protocols change. It is not a check
// of the text: what is not understood is left out.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

namespace spheretree::device {

/// A step from a value to one inside it: the key of a member, or the index of an element, whose key is empty.
struct JsonStep {
  std::string_view key;
  std::size_t index = 0;
};

inline constexpr std::size_t kJsonDepth = 12;  // deeper texts are not ours

/// A place in a text.
struct JsonCursor {
  std::string_view text;
  std::size_t at = 0;

  /// Whether something other than blanks follows.
  bool toNext() noexcept {
    while (at < text.size() && (text[at] == ' ' || text[at] == '\t' || text[at] == '\n' || text[at] == '\r')) ++at;
    return at < text.size();
  }
  bool take(char c) noexcept { return toNext() && text[at++] == c; }
  /// A string without its quotes; the opening one has been read.
  std::optional<std::string_view> string() noexcept {
    const std::size_t begin = at;
    for (; at < text.size() && text[at] != '"'; ++at)
      if (text[at] == '\\') ++at;
    if (at >= text.size()) return std::nullopt;
    return text.substr(begin, at++ - begin);
  }
  /// A number or word, which may be empty.
  std::string_view word() noexcept {
    const std::size_t begin = at;
    while (at < text.size() && text[at] != ',' && text[at] != '}' && text[at] != ']' && text[at] > ' ') ++at;
    return text.substr(begin, at - begin);
  }
};

/// Calls visit(path, value) for each number, string (without its quotes, escapes as they are) and word of `text`.
/// Returns false if the text breaks off, nests deeper than kJsonDepth or has no JSON where a value must be.
template <class Visit>
bool scanJson(std::string_view text, const Visit& visit) noexcept {
  std::array<JsonStep, kJsonDepth> path;
  std::array<bool, kJsonDepth> is_object{};
  std::size_t depth = 0;
  JsonCursor in{text};
  const auto readKey = [&] {  // "key":
    if (!in.take('"')) return false;
    const std::optional<std::string_view> key = in.string();
    if (!key || !in.take(':')) return false;
    path[depth - 1].key = *key;
    return true;
  };
  for (;;) {
    if (!in.toNext()) return false;
    const char first = text[in.at];
    if (first == '{' || first == '[') {
      if (depth == kJsonDepth) return false;
      const bool object = is_object[depth] = text[in.at++] == '{';
      path[depth++] = {};
      const bool is_empty = in.toNext() && text[in.at] == (object ? '}' : ']');
      if (!is_empty) {
        if (object && !readKey()) return false;
        continue;
      }
    } else if (first == '"') {
      ++in.at;
      const std::optional<std::string_view> value = in.string();
      if (!value) return false;
      visit(std::span<const JsonStep>(path.data(), depth), *value);
    } else {
      const std::string_view value = in.word();
      if (value.empty()) return false;
      visit(std::span<const JsonStep>(path.data(), depth), value);
    }
    // After a value: the next one, or the ends of what it is in.
    for (;;) {
      if (depth == 0) return true;
      if (!in.toNext()) return false;
      const char c = text[in.at++];
      if (c == ',') {
        ++path[depth - 1].index;
        if (is_object[depth - 1] && !readKey()) return false;
        break;
      }
      if (c != (is_object[depth - 1] ? '}' : ']')) return false;
      --depth;
    }
  }
}

/// The number that `text` is; nothing if it is none. NaN and infinities are numbers here: safety rules judge them.
inline std::optional<double> numberIn(std::string_view text) noexcept {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

}  // namespace spheretree::device
