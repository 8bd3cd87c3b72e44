// SPDX-License-Identifier: Apache-2.0
// Texts for readers, and the messages of readers.
#pragma once

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <string_view>

namespace spheretree::test {

inline std::span<const char> charsOf(std::string_view text) { return {text.data(), text.size()}; }

/// The message of the Error that `read` throws; empty if it throws none.
template <class Error, class Read>
std::string refusalOf(Read&& read) {
  try {
    read();
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

inline bool has(std::string_view text, std::string_view part) { return text.find(part) != std::string_view::npos; }

/// `text` with the first `from` replaced; it must be there.
inline std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

}  // namespace spheretree::test
