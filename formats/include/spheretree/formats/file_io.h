// SPDX-License-Identifier: Apache-2.0
// Whole files in and out. A file appears under its name only when it is whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

namespace spheretree::formats {

inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t{4} << 30;  // 4 GiB

/// All bytes of a file, pipe or device.
/// @throws FileError if it cannot be opened or read, is a folder, or has more than `max_bytes`.
std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t max_bytes = kMaxFileBytes);

/// Writes under a temporary name in the same folder, syncs to disk and renames; symbolic links are followed. An older file of
/// that name stays untouched until the rename, and keeps its permissions. Whatever fails, the temporary file is removed.
/// A device or pipe (/dev/stdout, /dev/null) cannot be replaced and is written straight.
/// @throws FileError if the folder is missing or read-only, `path` is a folder or a read-only file, or the disk is full.
void writeWhole(const std::filesystem::path& path, std::span<const std::byte> bytes);
void writeWhole(const std::filesystem::path& path, std::string_view text);

/// Before long work: refuses what writeWhole() is sure to refuse (missing folder, no permission, `path` is a folder). Writes nothing.
/// @throws FileError
void checkWritable(const std::filesystem::path& path);

}  // namespace spheretree::formats
