// SPDX-License-Identifier: Apache-2.0
// The bytes of a .stree file, in memory: encode and decode side by side. The layout: docs/file_format.md
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree {

inline constexpr std::uint16_t kFormatMajor = 1;  // a reader refuses any other
inline constexpr std::uint16_t kFormatMinor = 0;  // a newer one only adds bytes at the end of the header
inline constexpr std::size_t kHeaderBytes = 320;  // of this version
inline constexpr std::size_t kArrayAlignment = 64;

enum class LoadStatus {
  Ok,
  BadMagic,
  UnsupportedVersion,
  Truncated,
  TrailingBytes,
  BadChecksum,
  BadHeader,    // a field of the header is out of range
  BadTopology,  // the tags in the radii do not make a tree of the node count
  BadTree,      // findFault() found something
  OutOfMemory,
};

/// What a status means and what to do, as one sentence.
std::string_view explain(LoadStatus status);

/// Bytes of a tree file. decodeSphereTree(encodeSphereTree(t)) == t, bit for bit.
/// @throws std::invalid_argument for a tree in which findFault() finds a fault.
std::vector<std::byte> encodeSphereTree(const SphereTree& tree);

/// Checks everything: a tree that comes out of here is sound (findFault). `tree` is changed only by Ok. Allocates in proportion to
/// the size of `bytes`, which need no alignment. `fault`, if given, gets the place and the values.
[[nodiscard]] LoadStatus decodeSphereTree(std::span<const std::byte> bytes, SphereTree& tree, std::string* fault = nullptr) noexcept;

/// CRC-64/XZ (ECMA-182 polynomial, reflected): what the header stores. Of "123456789": 0x995dc9bbdf1939fa.
/// `crc`: the value so far, so that a sum can be taken in pieces.
std::uint64_t crc64(std::span<const std::byte> bytes, std::uint64_t crc = 0);

}  // namespace spheretree
