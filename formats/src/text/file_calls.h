// SPDX-License-Identifier: Apache-2.0
// What reading and writing whole files asks of the system: file_calls_posix.cpp and file_calls_windows.cpp. Errors are
// numbers of <cerrno>; 0: none.
#pragma once

#include <cstdint>
#include <ctime>
#include <filesystem>

namespace spheretree::formats {

enum class FileKind { Regular, Folder, Other };  // Other: a device or a pipe

struct FileStatus {
  FileKind kind = FileKind::Other;
  std::uint64_t size = 0;               // [bytes]
  std::uint64_t device = 0, inode = 0;  // what identifies a regular file
  unsigned permissions = 0;             // as setPermissions() takes them
};

/// Of the file that links lead to. Returns an error.
int findStatus(const std::filesystem::path& path, FileStatus& status);
int findStatus(int file, FileStatus& status);

/// Whether this program may replace a file, or create files in a folder. Returns an error.
int checkReplaceable(const std::filesystem::path& file);
int checkFolder(const std::filesystem::path& folder);

/// Descriptors, which no child inherits, of bytes that are passed on as they are; -1 with the reason in errno.
int openToRead(const std::filesystem::path& path);   // waits for the writer of a named pipe
int openAtOnce(const std::filesystem::path& path);   // to read; waits for nothing
int openToWrite(const std::filesystem::path& path);  // a device or a pipe
int openNew(const std::filesystem::path& path);      // to write; held until it is closed
int duplicateStandard(int stream);                   // of standard input or output

/// Whether `path` is a regular file and no link, was last written before `time`, and no program holds it.
bool isAbandoned(const std::filesystem::path& path, std::time_t time);

/// Return an error.
int setPermissions(int file, unsigned permissions);
int syncFile(int file);
int replaceFile(const std::filesystem::path& by, const std::filesystem::path& target);  // at once

/// Syncs all files of the folder's file system, also those that are closed; canSyncDisk() says whether there is such a
/// call. Returns an error.
bool canSyncDisk();
int syncDisk(const std::filesystem::path& folder);

/// A rename survives a power failure only after the folder is synced. Some file systems cannot sync folders; the file
/// is complete in any case.
void syncFolder(const std::filesystem::path& folder);

/// Whether the disk, or the user's share of it, is full.
bool isFullDisk(int error);

}  // namespace spheretree::formats
