// SPDX-License-Identifier: Apache-2.0
// Unsigned numbers of binary formats, independent of the byte order of the machine.
#pragma once

#include <cstddef>
#include <cstdint>

namespace spheretree::formats {

/// From `size` bytes, at most 8.
inline std::uint64_t littleBits(const void* bytes, std::size_t size) {
  const auto* first = static_cast<const unsigned char*>(bytes);
  std::uint64_t bits = 0;
  for (std::size_t k = size; k-- > 0;) bits = bits << 8 | first[k];
  return bits;
}

inline std::uint32_t littleUint32(const void* bytes) { return static_cast<std::uint32_t>(littleBits(bytes, 4)); }

}  // namespace spheretree::formats
