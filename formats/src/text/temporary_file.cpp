// SPDX-License-Identifier: Apache-2.0
#include "text/temporary_file.h"

#include <atomic>
#include <ctime>
#include <mutex>
#include <set>
#include <string>
#include <system_error>

#include "spheretree/formats/path_name.h"
#include "text/file_calls.h"

namespace spheretree::formats {
namespace {

constexpr std::string_view kPrefix = ".spheretree-", kSuffix = ".tmp";

// A file is created shortly before it is locked, and some file systems do not share locks between machines. A program
// that still writes a file does so repeatedly, or finishes within seconds.
constexpr std::time_t kLeftAlone = 600;  // age below which unlocked files are kept [s]

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
    const std::string name = toUtf8(at->path().filename());
    std::error_code ignored;
    if (name.starts_with(kPrefix) && name.ends_with(kSuffix) && isAbandoned(at->path(), std::time(nullptr) - kLeftAlone))
      std::filesystem::remove(at->path(), ignored);
  }
}

}  // namespace

TemporaryFile createTemporary(const std::filesystem::path& folder) {
  static std::atomic<unsigned> counter{0};
  sweep(folder);
  for (;;) {
    std::filesystem::path path =
        folder / (std::string(kPrefix) + std::to_string(::getpid()) + "-" + std::to_string(counter++) + std::string(kSuffix));
    Descriptor file(openNew(path));
    if (file.get() >= 0) return {std::move(path), std::move(file), 0};
    if (errno != EEXIST && errno != EINTR) return {{}, std::move(file), errno};
  }
}

}  // namespace spheretree::formats
