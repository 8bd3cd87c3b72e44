// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/file_io.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "spheretree/formats/errors.h"

namespace spheretree::formats {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

[[noreturn]] void failRead(const std::filesystem::path& path, int error) {
  throw FileError(path.string() + ": cannot be read: " + reason(error) + ". Check the name and the permissions.");
}

[[noreturn]] void failWrite(const std::filesystem::path& path, int error) {
  const char* advice = error == ENOSPC || error == EDQUOT    ? "Free some space or write elsewhere."
                       : error == ENOENT || error == ENOTDIR ? "Create the folder first."
                       : error == EISDIR                     ? "Name a file, not a folder."
                                                             : "Check the folder's permissions or write elsewhere.";
  throw FileError(path.string() + ": cannot be written: " + reason(error) + ". " + advice);
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  /// Some file systems report a full disk only here. 0 or an errno.
  int close() {
    const int fd = fd_;
    fd_ = -1;
    return ::close(fd) == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

/// 0 or an errno.
int writeAll(int fd, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), std::min<std::size_t>(bytes.size(), std::size_t{1} << 30));
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

/// Whether there is something at `path`; refuses what cannot be written to.
bool statTarget(const std::filesystem::path& path, struct stat& status) {
  if (::stat(path.c_str(), &status) != 0) {
    if (errno != ENOENT) failWrite(path, errno);
    return false;
  }
  if (S_ISDIR(status.st_mode)) failWrite(path, EISDIR);
  if (::access(path.c_str(), W_OK) != 0) failWrite(path, errno);
  return true;
}

struct Temporary {
  std::filesystem::path path;
  int fd;
};

Temporary createTemporary(const std::filesystem::path& folder, const std::filesystem::path& target) {
  static std::atomic<unsigned> counter{0};
  for (;;) {
    const std::string name = ".spheretree-" + std::to_string(::getpid()) + "-" + std::to_string(counter++) + ".tmp";
    std::filesystem::path path = folder / name;
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd >= 0) return {std::move(path), fd};
    if (errno != EEXIST && errno != EINTR) failWrite(target, errno);
  }
}

}  // namespace

std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t max_bytes) {
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) failRead(path, errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) failRead(path, errno);
  if (S_ISDIR(status.st_mode)) failRead(path, EISDIR);
  const auto refuseSize = [&] {
    throw FileError(path.string() + ": has more than " + std::to_string(max_bytes) + " bytes, the most that is read of such a file.");
  };
  if (S_ISREG(status.st_mode) && static_cast<std::uint64_t>(status.st_size) > max_bytes) refuseSize();

  // The size is a first guess only: pipes have none, and a file may change while it is read.
  std::vector<std::byte> bytes;
  std::size_t used = 0;
  bytes.resize(S_ISREG(status.st_mode) ? static_cast<std::size_t>(status.st_size) + 1 : std::size_t{1} << 16);
  for (;;) {
    if (used == bytes.size()) bytes.resize(bytes.size() * 2);
    const ssize_t count = ::read(file.get(), bytes.data() + used, std::min<std::size_t>(bytes.size() - used, std::size_t{1} << 30));
    if (count < 0) {
      if (errno == EINTR) continue;
      failRead(path, errno);
    }
    if (count == 0) break;
    used += static_cast<std::size_t>(count);
    if (used > max_bytes) refuseSize();
  }
  bytes.resize(used);
  return bytes;
}

void checkWritable(const std::filesystem::path& path) {
  struct stat status {};
  if (statTarget(path, status)) return;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  if (!path.has_filename()) failWrite(path, EISDIR);
  if (::access(folder.c_str(), W_OK | X_OK) != 0) failWrite(path, errno);
}

void makeFolder(const std::filesystem::path& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error) throw FileError(path.string() + ": cannot be made: " + error.message() + ". Choose another folder.");
}

struct WholeFile::State {
  std::filesystem::path path, target, temporary;  // as asked for, links followed, what is written to; `temporary` empty: straight
  Descriptor file;
  bool keep_mode = false;
  mode_t mode = 0;
};

WholeFile::WholeFile(const std::filesystem::path& path) {
  struct stat status {};
  const bool exists = statTarget(path, status);
  if (exists && !S_ISREG(status.st_mode)) {  // a device or pipe
    const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (fd < 0) failWrite(path, errno);
    state_.reset(new State{path, path, {}, Descriptor(fd), false, 0});
    return;
  }
  std::error_code unresolved;
  std::filesystem::path target = exists ? std::filesystem::canonical(path, unresolved) : path;
  if (unresolved) target = path;
  if (!target.has_filename()) failWrite(path, EISDIR);
  const std::filesystem::path folder = target.has_parent_path() ? target.parent_path() : std::filesystem::path(".");
  Temporary temporary = createTemporary(folder, path);
  state_.reset(new State{path, std::move(target), std::move(temporary.path), Descriptor(temporary.fd), exists, status.st_mode});
}

WholeFile::~WholeFile() {
  if (state_ && !state_->temporary.empty()) ::unlink(state_->temporary.c_str());
}

void WholeFile::append(std::span<const std::byte> bytes) {
  if (const int error = writeAll(state_->file.get(), bytes)) failWrite(state_->path, error);
}

void WholeFile::append(std::string_view text) { append(std::as_bytes(std::span<const char>(text.data(), text.size()))); }

void WholeFile::commit() {
  State& s = *state_;
  const bool straight = s.temporary.empty();
  int error = 0;
  if (!straight && s.keep_mode && ::fchmod(s.file.get(), s.mode & 07777) != 0) error = errno;
  if (!straight && !error && ::fsync(s.file.get()) != 0) error = errno;
  const int close_error = s.file.close();
  if (!error) error = close_error;
  if (!straight && !error && ::rename(s.temporary.c_str(), s.target.c_str()) != 0) error = errno;
  if (error) failWrite(s.path, error);
  if (straight) return;
  s.temporary.clear();
  // The rename itself survives a power cut only once the folder is synced; not every file system can, and the file is whole.
  const std::filesystem::path folder = s.target.has_parent_path() ? s.target.parent_path() : std::filesystem::path(".");
  const Descriptor folder_file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder_file.get() >= 0) ::fsync(folder_file.get());
}

void writeWhole(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  WholeFile file(path);
  file.append(bytes);
  file.commit();
}

void writeWhole(const std::filesystem::path& path, std::string_view text) {
  writeWhole(path, std::as_bytes(std::span<const char>(text.data(), text.size())));
}

}  // namespace spheretree::formats
