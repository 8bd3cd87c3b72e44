// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

#include "text/file_calls.h"
#include "text/temporary_file.h"

namespace spheretree::formats {
namespace {

int errorOf(int result) { return result == 0 ? 0 : errno; }

FileStatus statusOf(const struct stat& from) {
  return {S_ISREG(from.st_mode)   ? FileKind::Regular
          : S_ISDIR(from.st_mode) ? FileKind::Folder
                                  : FileKind::Other,
          static_cast<std::uint64_t>(from.st_size), static_cast<std::uint64_t>(from.st_dev), static_cast<std::uint64_t>(from.st_ino),
          from.st_mode & 07777};
}

}  // namespace

int findStatus(const std::filesystem::path& path, FileStatus& status) {
  struct stat found {};
  const int error = errorOf(::stat(path.c_str(), &found));
  if (!error) status = statusOf(found);
  return error;
}

int findStatus(int file, FileStatus& status) {
  struct stat found {};
  const int error = errorOf(::fstat(file, &found));
  if (!error) status = statusOf(found);
  return error;
}

int checkReplaceable(const std::filesystem::path& file) { return errorOf(::access(file.c_str(), W_OK)); }
int checkFolder(const std::filesystem::path& folder) { return errorOf(::access(folder.c_str(), W_OK | X_OK)); }

int openToRead(const std::filesystem::path& path) { return ::open(path.c_str(), O_RDONLY | O_CLOEXEC); }
int openAtOnce(const std::filesystem::path& path) { return ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC); }
int openToWrite(const std::filesystem::path& path) { return ::open(path.c_str(), O_WRONLY | O_CLOEXEC); }

int openNew(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file >= 0) (void)::flock(file, LOCK_EX | LOCK_NB);  // if it cannot be locked, its age must suffice
  return file;
}

int duplicateStandard(int stream) { return ::fcntl(stream, F_DUPFD_CLOEXEC, 3); }

bool isAbandoned(const std::filesystem::path& path, std::time_t time) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_mtime > time) return false;
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  return file.get() >= 0 && ::flock(file.get(), LOCK_EX | LOCK_NB) == 0;
}

int setPermissions(int file, unsigned permissions) { return errorOf(::fchmod(file, permissions)); }
int syncFile(int file) { return errorOf(::fsync(file)); }
int replaceFile(const std::filesystem::path& by, const std::filesystem::path& target) {
  return errorOf(::rename(by.c_str(), target.c_str()));
}

bool canSyncDisk() { return true; }

int syncDisk(const std::filesystem::path& folder) {
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  return descriptor.get() < 0 ? errno : errorOf(::syncfs(descriptor.get()));
}

void syncFolder(const std::filesystem::path& folder) {
  const Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.get() >= 0) ::fsync(descriptor.get());
}

bool isFullDisk(int error) { return error == ENOSPC || error == EDQUOT; }

}  // namespace spheretree::formats
