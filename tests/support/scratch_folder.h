// SPDX-License-Identifier: Apache-2.0
// A temporary folder of a test, removed with its content.
#pragma once

#include <filesystem>
#include <random>
#include <string>
#include <system_error>

namespace spheretree::test {

class ScratchFolder {
 public:
  ScratchFolder() {
    std::random_device number;
    do path_ = std::filesystem::temp_directory_path() / ("spheretree_test_" + std::to_string(number()));
    while (!std::filesystem::create_directory(path_));  // false: there is one
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace spheretree::test
