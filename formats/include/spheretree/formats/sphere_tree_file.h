// SPDX-License-Identifier: Apache-2.0
// The codec of core, plus the file. The layout: docs/file_format.md
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/tissue.h"

namespace spheretree::formats {

/// Largest size of a .stree file that is read: the largest tree, search tree and skin take 2.6 MB, and the remainder
/// allows for future sections. A .soft file may be larger, because it also holds tissue.
inline constexpr std::uint64_t kMaxTreeBytes = 16 << 20, kMaxSoftBytes = 256 << 20;

/// Every tree that is returned is sound (findFault of core).
/// @throws FileError if the file cannot be read, FormatError if it is damaged, of another version or not a tree.
SphereTree readSphereTree(const std::filesystem::path& path);

/// As readSphereTree(), from bytes in memory; `name` is the prefix of messages.
/// @throws FormatError
SphereTree parseSphereTree(std::span<const std::byte> bytes, const std::string& name);

/// A tree and its tissue from a .soft file; from a .stree file, with `tissue` empty.
/// @throws as readSphereTree
SphereTree readSoftTree(const std::filesystem::path& path, Tissue& tissue);

/// As readSoftTree(), from bytes in memory; `name` is the prefix of messages.
/// @throws FormatError
SphereTree parseSoftTree(std::span<const std::byte> bytes, const std::string& name, Tissue& tissue);

/// Writes the file atomically (writeWhole).
/// @throws FileError if the file cannot be written, std::invalid_argument for an unsound tree.
void writeSphereTree(const std::filesystem::path& path, const SphereTree& tree);

}  // namespace spheretree::formats
