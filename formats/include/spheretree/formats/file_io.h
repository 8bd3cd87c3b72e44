// SPDX-License-Identifier: Apache-2.0
// Reads and writes whole files. Output files are written atomically: a file gets its name once it is complete.
#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::formats {

inline constexpr std::uint64_t kMaxFileBytes = std::uint64_t{4} << 30;  // 4 GiB

/// The role of a file for the program that reads or writes it.
enum class FileRole {
  User,    // named by a user, or part of a file that is: an input or an output
  Working  // internal to the program, which may read and replace it: an entry of a cache
};

/// Identifies a file under all of its names: other paths, links, hard links. idOf() is empty for pipes, devices and
/// files that do not exist.
struct FileId {
  std::uint64_t device = 0, inode = 0;
  friend auto operator<=>(const FileId&, const FileId&) = default;
};
std::optional<FileId> idOf(const std::filesystem::path& path);

/// While it is set, it is notified of every file of role User that is read and of every file that is written, so that a
/// program can refuse to replace what it has read. It may be called from any thread. An exception that it throws
/// reaches the caller of the function that reads or writes.
class FileObserver {
 public:
  virtual ~FileObserver() = default;
  /// Called once the file is open.
  virtual void onRead(const std::filesystem::path& path, const FileId& id) = 0;
  /// Called before anything is written. `target`: `path` with all links followed.
  virtual void onWrite(const std::filesystem::path& path, const std::filesystem::path& target, const std::optional<FileId>& id,
                       FileRole role) = 0;
  /// Called before the file gets its name: `complete` holds its bytes. It is `target` if that has them already.
  virtual void onComplete(const std::filesystem::path& path, const std::filesystem::path& target, const std::filesystem::path& complete,
                          FileRole role) = 0;
  /// Called once the file has its name.
  virtual void onWritten(const std::filesystem::path& target, FileRole role) = 0;
  /// Called before a file is opened for reading, and when a signal interrupts a read. An exception ends the reading.
  virtual void checkInterrupted() = 0;
};

/// Sets the observer; null: none. Returns the previous one.
FileObserver* setFileObserver(FileObserver* observer) noexcept;

/// A name for messages: the path, or "standard input" for "-".
std::string shownName(const std::filesystem::path& path);

/// All bytes of a file, pipe or device; "-" is standard input.
/// @throws FileError if it cannot be opened or read, is a folder, or has more than `max_bytes`.
std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t max_bytes = kMaxFileBytes, FileRole role = FileRole::User);

/// `path` with all links followed, including links to files that do not exist: the file that a write to this name
/// creates.
/// @throws FileError for a circle of links.
std::filesystem::path linkTarget(const std::filesystem::path& path);

/// A file that is written piece by piece under a temporary name in the same folder. commit() syncs it to disk and
/// renames it. Without commit(), the temporary file is removed, and an older file of that name stays unchanged.
/// Symbolic links are followed; permissions of an older file are kept. Devices and pipes (/dev/null) and standard
/// output ("-") cannot be replaced and are written directly. Temporary files that a killed program left in the folder
/// are removed.
class WholeFile {
 public:
  /// @throws FileError if the folder is missing or read-only, or `path` is a folder or a read-only file.
  explicit WholeFile(const std::filesystem::path& path, FileRole role = FileRole::User);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  /// @throws FileError, for example for a full disk.
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text);
  /// Call once, at the end. @throws FileError; an older file of that name is then unchanged.
  void commit();

 private:
  friend class WholeFiles;
  struct State;
  std::unique_ptr<State> state_;
};

/// Many files, each written atomically like a WholeFile: all are written under temporary names, synced to disk by one
/// request to the file system (syncfs), and then renamed. A sync for each file would take some 10 ms a file. A file
/// that already has the same bytes is not touched.
class WholeFiles {
 public:
  WholeFiles();
  ~WholeFiles();
  WholeFiles(const WholeFiles&) = delete;
  WholeFiles& operator=(const WholeFiles&) = delete;
  /// @throws FileError as WholeFile.
  void add(const std::filesystem::path& path, std::span<const std::byte> bytes, FileRole role = FileRole::User);
  /// Call once, at the end. @throws FileError if a file cannot be renamed; the files after it are then not replaced
  /// either.
  void commit();

 private:
  std::vector<std::unique_ptr<WholeFile>> files_;
};

/// Writes a whole file in one call.
/// @throws FileError as WholeFile.
void writeWhole(const std::filesystem::path& path, std::span<const std::byte> bytes, FileRole role = FileRole::User);
void writeWhole(const std::filesystem::path& path, std::string_view text, FileRole role = FileRole::User);

/// For use before long work: refuses paths that writeWhole() is sure to refuse (missing folder, no permission, `path`
/// is a folder). Writes nothing.
/// @throws FileError
void checkWritable(const std::filesystem::path& path);

/// Creates the folder, and those above it, if they are missing.
/// @throws FileError if they cannot be created or `path` is something else.
void makeFolder(const std::filesystem::path& path);

}  // namespace spheretree::formats
