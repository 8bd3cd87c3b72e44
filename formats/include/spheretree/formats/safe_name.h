// SPDX-License-Identifier: Apache-2.0
// Names of objects, which are also names of files: letters and digits of any script in UTF-8, and _ - . but not - or .
// first.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace spheretree::formats {

inline constexpr std::size_t kMaxNameBytes = 64;

/// Whether `name` has 1 to kMaxNameBytes bytes and only the characters above.
bool isSafeName(std::string_view name);

/// `wanted` with every other run of characters as one _; "part" if nothing is left.
std::string safeName(std::string_view wanted);

/// The first `bytes` bytes of a text, less if these would end within a character.
std::string_view cutName(std::string_view name, std::size_t bytes);

/// `text` if it is UTF-8; otherwise its bytes as letters of Latin-1.
std::string asUtf8(std::string_view text);

}  // namespace spheretree::formats
