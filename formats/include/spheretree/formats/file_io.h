// SPDX-License-Identifier: Apache-2.0
// Whole files in and out. A file appears under its name only when it is whole.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

namespace spheretree::formats {

inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t{4} << 30;  // 4 GiB

/// All bytes of a file, pipe or device.
/// @throws FileError if it cannot be opened or read, is a folder, or has more than `max_bytes`.
std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t max_bytes = kMaxFileBytes);

/// A file written piece by piece under a temporary name in the same folder. commit() syncs it to disk and renames it; without, the
/// temporary file is removed and an older file of that name stays as it was. Symbolic links are followed; permissions of an older file
/// stay. A device or pipe (/dev/stdout, /dev/null) cannot be replaced and is written straight.
class WholeFile {
 public:
  /// @throws FileError if the folder is missing or read-only, or `path` is a folder or a read-only file.
  explicit WholeFile(const std::filesystem::path& path);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  /// @throws FileError, for a full disk.
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text);
  /// Once, at the end. @throws FileError; nothing then stands under the name that did not before.
  void commit();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// All at once.
/// @throws FileError as WholeFile.
void writeWhole(const std::filesystem::path& path, std::span<const std::byte> bytes);
void writeWhole(const std::filesystem::path& path, std::string_view text);

/// Before long work: refuses what writeWhole() is sure to refuse (missing folder, no permission, `path` is a folder). Writes nothing.
/// @throws FileError
void checkWritable(const std::filesystem::path& path);

/// The folder, and those above it, if they are missing.
/// @throws FileError if they cannot be made or `path` is something else.
void makeFolder(const std::filesystem::path& path);

}  // namespace spheretree::formats
