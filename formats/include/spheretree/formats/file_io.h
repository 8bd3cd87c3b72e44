// SPDX-License-Identifier: Apache-2.0
// Whole files in and out. A file appears under its name only when it is whole.
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

/// What a file is to the program that reads or writes it.
enum class FileRole {
  User,    // named by a user, or part of something that is: an input or an output
  Working  // the program's own, which it may read and replace: an entry of a cache
};

/// The same for every name of a file: other paths, links, hard links. Nothing for pipes, devices and what is not there.
struct FileId {
  std::uint64_t device = 0, inode = 0;
  friend auto operator<=>(const FileId&, const FileId&) = default;
};
std::optional<FileId> idOf(const std::filesystem::path& path);

/// Is told of every file of role User that is read, and of every file that is written, while it is set, so that a
/// program can refuse to replace what it has read. Called from any thread; what it throws reaches the caller of the
/// function that reads or writes.
class FileObserver {
 public:
  virtual ~FileObserver() = default;
  /// Once the file is open.
  virtual void onRead(const std::filesystem::path& path, const FileId& id) = 0;
  /// Before anything is written, and again before the file gets its name. `target`: `path` with all links followed.
  virtual void onWrite(const std::filesystem::path& path, const std::filesystem::path& target, const std::optional<FileId>& id,
                       FileRole role) = 0;
  /// The file has its name.
  virtual void onWritten(const std::filesystem::path& target, FileRole role) = 0;
  /// Before a file is opened to be read, and when a signal comes while reading waits. What it throws ends the reading.
  virtual void checkInterrupted() = 0;
};

/// Null: none. Returns the one before.
FileObserver* setFileObserver(FileObserver* observer) noexcept;

/// For messages: the path, or "standard input" for "-".
std::string shownName(const std::filesystem::path& path);

/// All bytes of a file, pipe or device; "-" is standard input.
/// @throws FileError if it cannot be opened or read, is a folder, or has more than `max_bytes`.
std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t max_bytes = kMaxFileBytes, FileRole role = FileRole::User);

/// `path` with all links followed, also those that lead nowhere yet: what a file written under this name becomes.
/// @throws FileError for a circle of links.
std::filesystem::path linkTarget(const std::filesystem::path& path);

/// A file written piece by piece under a temporary name in the same folder. commit() syncs it to disk and renames it;
/// without, the temporary file is removed and an older file of that name stays as it was. Symbolic links are followed;
/// permissions of an older file stay. A device or pipe (/dev/null) cannot be replaced and is written straight, and so
/// is standard output, which is "-". Temporary files that a killed program left in the folder are removed.
class WholeFile {
 public:
  /// @throws FileError if the folder is missing or read-only, or `path` is a folder or a read-only file.
  explicit WholeFile(const std::filesystem::path& path, FileRole role = FileRole::User);
  ~WholeFile();
  WholeFile(const WholeFile&) = delete;
  WholeFile& operator=(const WholeFile&) = delete;
  /// @throws FileError, for a full disk.
  void append(std::span<const std::byte> bytes);
  void append(std::string_view text);
  /// Once, at the end. @throws FileError; nothing then stands under the name that did not before.
  void commit();

 private:
  friend class WholeFiles;
  struct State;
  std::unique_ptr<State> state_;
};

/// Many files, each as whole as a WholeFile: all are written under temporary names, synced to disk by one request to
/// the file system (syncfs), and then renamed. One request for each file would take some 10 ms a file. A file that
/// already holds the same bytes is left as it is.
class WholeFiles {
 public:
  WholeFiles();
  ~WholeFiles();
  WholeFiles(const WholeFiles&) = delete;
  WholeFiles& operator=(const WholeFiles&) = delete;
  /// @throws FileError as WholeFile.
  void add(const std::filesystem::path& path, std::span<const std::byte> bytes, FileRole role = FileRole::User);
  /// Once, at the end. @throws FileError; those that come after the one that cannot be renamed are then not replaced.
  void commit();

 private:
  std::vector<std::unique_ptr<WholeFile>> files_;
};

/// All at once.
/// @throws FileError as WholeFile.
void writeWhole(const std::filesystem::path& path, std::span<const std::byte> bytes, FileRole role = FileRole::User);
void writeWhole(const std::filesystem::path& path, std::string_view text, FileRole role = FileRole::User);

/// Before long work: refuses what writeWhole() is sure to refuse (missing folder, no permission, `path` is a folder).
/// Writes nothing.
/// @throws FileError
void checkWritable(const std::filesystem::path& path);

/// The folder, and those above it, if they are missing.
/// @throws FileError if they cannot be made or `path` is something else.
void makeFolder(const std::filesystem::path& path);

}  // namespace spheretree::formats
