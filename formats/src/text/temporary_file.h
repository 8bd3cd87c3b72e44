// SPDX-License-Identifier: Apache-2.0
// The temporary files that contain an output until it is complete, and the removal of those that killed programs left
// behind.
#pragma once

#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

namespace spheretree::formats {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  int get() const { return fd_; }
  /// Some file systems report a full disk only here. Returns 0 or an errno.
  int close() {
    const int fd = std::exchange(fd_, -1);
    return ::close(fd) == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

struct TemporaryFile {
  std::filesystem::path path;
  Descriptor file;  // -1: it could not be created
  int error;        // the reason: an errno
};

/// A new empty file `.spheretree-PID-N.tmp` in `folder`, locked while it is open. Before the first one in a folder,
/// removes temporary files that are unlocked and older than ten minutes, which are left from killed programs.
TemporaryFile createTemporary(const std::filesystem::path& folder);

}  // namespace spheretree::formats
