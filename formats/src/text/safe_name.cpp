// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/safe_name.h"

#include <algorithm>
#include <array>
#include <cstdint>

namespace spheretree::formats {
namespace {

constexpr std::uint32_t kInvalid = 0xffffffff;

/// Removes the first character of a text; kInvalid, and one byte, where it is not UTF-8.
std::uint32_t takeCharacter(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t first = byte(0);
  const std::size_t size = first < 0x80                    ? 1
                           : first >= 0xc2 && first < 0xe0 ? 2
                           : first >= 0xe0 && first < 0xf0 ? 3
                           : first >= 0xf0 && first < 0xf5 ? 4
                                                           : 0;
  std::uint32_t character = size == 1 ? first : size > 0 ? first & (0x7fu >> size) : kInvalid;
  for (std::size_t i = 1; i < size && character != kInvalid; ++i)
    character = i < text.size() && (byte(i) & 0xc0) == 0x80 ? character << 6 | (byte(i) & 0x3f) : kInvalid;
  const bool is_overlong = (size == 3 && character < 0x800) || (size == 4 && character < 0x10000);
  if (is_overlong || (character >= 0xd800 && character < 0xe000) || (character > 0x10ffff && character != kInvalid)) character = kInvalid;
  text.remove_prefix(character == kInvalid ? 1 : size);
  return character;
}

/// Beyond ASCII: all but controls, blanks, punctuation, symbols that turn the direction of a text, and private use.
bool isPlain(std::uint32_t c) {
  if (c < 0x80) return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' || c == '-' || c == '.';
  constexpr std::array<std::array<std::uint32_t, 2>, 9> kExcluded{{{0x80, 0xbf},
                                                                   {0xd7, 0xd7},
                                                                   {0xf7, 0xf7},
                                                                   {0x61c, 0x61c},
                                                                   {0x2000, 0x2bff},
                                                                   {0x3000, 0x3004},
                                                                   {0xe000, 0xf8ff},
                                                                   {0xfe00, 0xfeff},
                                                                   {0xfff0, 0xffff}}};
  return c < 0xe0000 && std::none_of(kExcluded.begin(), kExcluded.end(), [&](const auto& range) { return c >= range[0] && c <= range[1]; });
}

}  // namespace

bool isSafeName(std::string_view name) {
  if (name.empty() || name.size() > kMaxNameBytes || name[0] == '-' || name[0] == '.') return false;
  while (!name.empty())
    if (!isPlain(takeCharacter(name))) return false;
  return true;
}

std::string safeName(std::string_view wanted) {
  const std::string text = asUtf8(wanted);
  std::string name;
  for (std::string_view rest = text; !rest.empty();) {
    const std::string_view before = rest;
    if (isPlain(takeCharacter(rest)))
      name += before.substr(0, before.size() - rest.size());
    else if (name.empty() || name.back() != '_')
      name += '_';
  }
  name.erase(0, std::min(name.size(), name.find_first_not_of("-.")));
  name = cutName(name, kMaxNameBytes);
  return name.empty() || name == "_" ? "part" : name;
}

std::string_view cutName(std::string_view name, std::size_t bytes) {
  if (name.size() <= bytes) return name;
  while (bytes > 0 && (static_cast<unsigned char>(name[bytes]) & 0xc0) == 0x80) --bytes;
  return name.substr(0, bytes);
}

std::string asUtf8(std::string_view text) {
  bool is_utf8 = true;
  for (std::string_view rest = text; !rest.empty() && is_utf8;) is_utf8 = takeCharacter(rest) != kInvalid;
  if (is_utf8) return std::string(text);
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80)
      out += c;
    else
      out += {static_cast<char>(0xc0 | byte >> 6), static_cast<char>(0x80 | (byte & 0x3f))};
  }
  return out;
}

}  // namespace spheretree::formats
