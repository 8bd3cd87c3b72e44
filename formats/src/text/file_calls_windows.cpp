// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <io.h>
#include <windows.h>

#include <cerrno>
#include <utility>

#include "text/file_calls.h"

namespace spheretree::formats {
namespace {

constexpr DWORD kSharedByAll = FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE;

class Handle {
 public:
  explicit Handle(HANDLE handle) : handle_(handle) {}
  ~Handle() {
    if (isOpen()) ::CloseHandle(handle_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  bool isOpen() const { return handle_ != INVALID_HANDLE_VALUE; }
  HANDLE get() const { return handle_; }
  HANDLE release() { return std::exchange(handle_, INVALID_HANDLE_VALUE); }

 private:
  HANDLE handle_;
};

int lastError() {
  switch (::GetLastError()) {
    case ERROR_FILE_NOT_FOUND:
    case ERROR_PATH_NOT_FOUND:
    case ERROR_BAD_PATHNAME:
    case ERROR_INVALID_NAME:
    case ERROR_BAD_NETPATH:
      return ENOENT;
    case ERROR_FILE_EXISTS:
    case ERROR_ALREADY_EXISTS:
      return EEXIST;
    case ERROR_DISK_FULL:
    case ERROR_HANDLE_DISK_FULL:
      return ENOSPC;
    case ERROR_FILENAME_EXCED_RANGE:
      return ENAMETOOLONG;
    case ERROR_TOO_MANY_OPEN_FILES:
      return EMFILE;
    case ERROR_SHARING_VIOLATION:
    case ERROR_LOCK_VIOLATION:
      return EBUSY;
    case ERROR_ACCESS_DENIED:
    case ERROR_WRITE_PROTECT:
      return EACCES;
    default:
      return EIO;
  }
}

FileStatus statusOf(HANDLE file) {
  BY_HANDLE_FILE_INFORMATION found{};
  if (::GetFileType(file) != FILE_TYPE_DISK || !::GetFileInformationByHandle(file, &found)) return {};
  return {found.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY ? FileKind::Folder : FileKind::Regular,
          std::uint64_t{found.nFileSizeHigh} << 32 | found.nFileSizeLow, found.dwVolumeSerialNumber,
          std::uint64_t{found.nFileIndexHigh} << 32 | found.nFileIndexLow, 0};
}

/// A descriptor of bytes, not of lines; -1 with the reason in errno.
int openFile(const std::filesystem::path& path, DWORD access, DWORD share, DWORD creation) {
  // A folder is opened, too: who reads one then learns that it is a folder.
  Handle file(::CreateFileW(path.c_str(), access, share, nullptr, creation, FILE_ATTRIBUTE_NORMAL | FILE_FLAG_BACKUP_SEMANTICS, nullptr));
  if (!file.isOpen()) {
    errno = lastError();
    return -1;
  }
  const int descriptor = ::_open_osfhandle(reinterpret_cast<std::intptr_t>(file.get()), _O_BINARY | _O_NOINHERIT);
  if (descriptor >= 0) file.release();
  return descriptor;
}

}  // namespace

int findStatus(const std::filesystem::path& path, FileStatus& status) {
  const Handle file(
      ::CreateFileW(path.c_str(), FILE_READ_ATTRIBUTES, kSharedByAll, nullptr, OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, nullptr));
  if (!file.isOpen()) return lastError();
  status = statusOf(file.get());
  return 0;
}

int findStatus(int file, FileStatus& status) {
  status = statusOf(reinterpret_cast<HANDLE>(::_get_osfhandle(file)));
  return 0;
}

int checkReplaceable(const std::filesystem::path& file) {
  const DWORD attributes = ::GetFileAttributesW(file.c_str());
  if (attributes == INVALID_FILE_ATTRIBUTES) return lastError();
  return attributes & FILE_ATTRIBUTE_READONLY ? EACCES : 0;
}

int checkFolder(const std::filesystem::path& folder) {
  const DWORD attributes = ::GetFileAttributesW(folder.c_str());
  if (attributes == INVALID_FILE_ATTRIBUTES) return lastError();
  return attributes & FILE_ATTRIBUTE_DIRECTORY ? 0 : ENOTDIR;
}

int openToRead(const std::filesystem::path& path) { return openFile(path, GENERIC_READ, kSharedByAll, OPEN_EXISTING); }
int openAtOnce(const std::filesystem::path& path) { return openToRead(path); }
int openToWrite(const std::filesystem::path& path) { return openFile(path, GENERIC_WRITE, kSharedByAll, OPEN_EXISTING); }
int openNew(const std::filesystem::path& path) { return openFile(path, GENERIC_WRITE, FILE_SHARE_READ, CREATE_NEW); }

int duplicateStandard(int stream) {
  const int file = ::_dup(stream);
  if (file >= 0) ::_setmode(file, _O_BINARY);
  return file;
}

bool isAbandoned(const std::filesystem::path& path, std::time_t time) {
  constexpr std::uint64_t kUnixEpoch = 11'644'473'600;  // seconds after 1601, from which Windows counts
  const Handle file(::CreateFileW(path.c_str(), GENERIC_READ, 0, nullptr, OPEN_EXISTING, FILE_FLAG_OPEN_REPARSE_POINT, nullptr));
  BY_HANDLE_FILE_INFORMATION found{};  // a file that somebody holds, or a folder, is not opened
  if (!file.isOpen() || !::GetFileInformationByHandle(file.get(), &found)) return false;
  if (found.dwFileAttributes & (FILE_ATTRIBUTE_DIRECTORY | FILE_ATTRIBUTE_REPARSE_POINT)) return false;
  const std::uint64_t written = std::uint64_t{found.ftLastWriteTime.dwHighDateTime} << 32 | found.ftLastWriteTime.dwLowDateTime;
  return written / 10'000'000 <= static_cast<std::uint64_t>(time) + kUnixEpoch;
}

int setPermissions(int, unsigned) { return 0; }  // they are those of the folder
int syncFile(int file) { return ::_commit(file) == 0 ? 0 : errno; }

int replaceFile(const std::filesystem::path& by, const std::filesystem::path& target) {
  // A file that is being read, by a scanner of viruses for example, cannot be replaced.
  for (int tries = 100;; --tries) {
    if (::MoveFileExW(by.c_str(), target.c_str(), MOVEFILE_REPLACE_EXISTING | MOVEFILE_WRITE_THROUGH)) return 0;
    const int error = lastError();
    if (tries == 0 || (error != EACCES && error != EBUSY)) return error;
    ::Sleep(10);
  }
}

bool canSyncDisk() { return false; }
int syncDisk(const std::filesystem::path&) { return 0; }
void syncFolder(const std::filesystem::path&) {}

bool isFullDisk(int error) { return error == ENOSPC; }

}  // namespace spheretree::formats
