// SPDX-License-Identifier: Apache-2.0
// Converts sections to and from arrays in their memory layout; used by the codecs of trees and of tissue.
#pragma once

#include <bit>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "describe.h"
#include "section_file.h"

namespace spheretree {

static_assert(std::endian::native == std::endian::little, "numbers and arrays are copied as they stand in the file");

using Bytes = std::vector<std::byte>;

template <class T>
void put(Bytes& bytes, const T& value) {
  const auto* first = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), first, first + sizeof value);
}

template <class T>
void putArray(Bytes& bytes, const std::vector<T>& values) {
  const auto* first = reinterpret_cast<const std::byte*>(values.data());
  bytes.insert(bytes.end(), first, first + values.size() * sizeof(T));
}

/// Reads a section from its beginning. The caller must have checked the size of the section against what it reads.
class Taker {
 public:
  explicit Taker(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <class T>
  T take() {
    T value;
    std::memcpy(&value, rest_.data(), sizeof value);
    rest_ = rest_.subspan(sizeof value);
    return value;
  }
  template <class T>
  void takeArray(std::vector<T>& values, std::size_t count) {
    values = std::vector<T>(count);
    if (count > 0) std::memcpy(static_cast<void*>(values.data()), rest_.data(), count * sizeof(T));
    rest_ = rest_.subspan(count * sizeof(T));
  }
  std::span<const std::byte> rest() const { return rest_; }

 private:
  std::span<const std::byte> rest_;
};

inline LoadStatus badSection(const Section& section, const char* what, std::string& fault, LoadStatus status = LoadStatus::BadSection) {
  fault = nameOf(section) + what;
  return status;
}

inline LoadStatus badSize(const Section& section, std::uint64_t expected, std::string& fault) {
  return badSection(section, describe(" has %zu bytes, not %zu", section.bytes.size(), std::size_t{expected}).c_str(), fault);
}

}  // namespace spheretree
