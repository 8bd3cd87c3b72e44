// SPDX-License-Identifier: Apache-2.0
// Takes .stree files apart and puts them together by docs/file_format.md, whatever their sections hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "spheretree/core/crc64.h"

namespace spheretree::test {

using Bytes = std::vector<std::byte>;

void put(Bytes& bytes, std::size_t offset, auto value) { std::memcpy(bytes.data() + offset, &value, sizeof value); }

template <class T>
T get(const Bytes& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

/// Corrects the checksum, so that a test reaches the checks after it.
inline Bytes resealed(Bytes bytes) {
  put(bytes, 24, std::uint64_t{0});
  put(bytes, 24, crc64(bytes));
  return bytes;
}

struct FileSection {
  std::string id;
  std::uint32_t flags;
  Bytes bytes;
};

inline std::vector<FileSection> takeApart(const Bytes& file) {
  std::vector<FileSection> sections;
  for (std::size_t i = 0; i < get<std::uint32_t>(file, 12); ++i) {
    const std::size_t entry = 32 + 24 * i;
    const auto first = file.begin() + static_cast<std::ptrdiff_t>(get<std::uint64_t>(file, entry + 8));
    sections.push_back({std::string(reinterpret_cast<const char*>(file.data()) + entry, 4), get<std::uint32_t>(file, entry + 4),
                        Bytes(first, first + static_cast<std::ptrdiff_t>(get<std::uint64_t>(file, entry + 16)))});
  }
  return sections;
}

inline Bytes putTogether(const std::vector<FileSection>& sections) {
  Bytes file(32 + 24 * sections.size());
  const std::uint8_t magic[8] = {0x89, 'S', 'T', 'R', 'E', 'E', '\r', '\n'};
  std::memcpy(file.data(), magic, sizeof magic);
  put(file, 8, std::uint32_t{1});
  put(file, 12, static_cast<std::uint32_t>(sections.size()));
  for (std::size_t i = 0; i < sections.size(); ++i) {
    file.resize((file.size() + 63) / 64 * 64);
    std::memcpy(file.data() + 32 + 24 * i, sections[i].id.data(), 4);
    put(file, 32 + 24 * i + 4, sections[i].flags);
    put(file, 32 + 24 * i + 8, std::uint64_t{file.size()});
    put(file, 32 + 24 * i + 16, std::uint64_t{sections[i].bytes.size()});
    file.insert(file.end(), sections[i].bytes.begin(), sections[i].bytes.end());
  }
  put(file, 16, std::uint64_t{file.size()});
  return resealed(file);
}

/// The section of this name; the test fails hard if there is none.
inline Bytes& sectionOf(std::vector<FileSection>& sections, const std::string& id) {
  for (FileSection& s : sections)
    if (s.id == id) return s.bytes;
  throw std::out_of_range("no section " + id);
}

}  // namespace spheretree::test
