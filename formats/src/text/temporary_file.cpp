// SPDX-License-Identifier: Apache-2.0
#include "text/temporary_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>

#include <atomic>
#include <ctime>
#include <mutex>
#include <set>
#include <string>
#include <system_error>

namespace spheretree::formats {
namespace {

constexpr std::string_view kPrefix = ".spheretree-", kSuffix = ".tmp";

// A file is created shortly before it is locked, and some file systems do not share locks between machines. A program
// that still writes a file does so repeatedly, or finishes within seconds.
constexpr std::time_t kLeftAlone = 600;  // age below which unlocked files are kept [s]

bool isLeftover(const std::filesystem::path& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode) || std::time(nullptr) - status.st_mtime < kLeftAlone) return false;
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  return file.get() >= 0 && ::flock(file.get(), LOCK_EX | LOCK_NB) == 0;
}

/// Once for each folder in a run of this program. Files that cannot be removed are kept.
void sweep(const std::filesystem::path& folder) {
  static std::mutex mutex;
  static std::set<std::filesystem::path> swept;
  {
    const std::lock_guard lock(mutex);
    if (!swept.insert(folder).second) return;
  }
  std::error_code failed;
  for (std::filesystem::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string name = at->path().filename().string();
    if (name.starts_with(kPrefix) && name.ends_with(kSuffix) && isLeftover(at->path())) ::unlink(at->path().c_str());
  }
}

}  // namespace

TemporaryFile createTemporary(const std::filesystem::path& folder) {
  static std::atomic<unsigned> counter{0};
  sweep(folder);
  for (;;) {
    std::filesystem::path path =
        folder / (std::string(kPrefix) + std::to_string(::getpid()) + "-" + std::to_string(counter++) + std::string(kSuffix));
    Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.get() >= 0) {
      (void)::flock(file.get(), LOCK_EX | LOCK_NB);  // if it cannot be locked, its age must suffice
      return {std::move(path), std::move(file), 0};
    }
    if (errno != EEXIST && errno != EINTR) return {{}, std::move(file), errno};
  }
}

}  // namespace spheretree::formats
