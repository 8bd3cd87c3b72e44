// SPDX-License-Identifier: Apache-2.0
// The interface of a fuzz target: the entry of libFuzzer, and valid inputs to start from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace spheretree::fuzz {

std::vector<std::string> seeds();

/// Stops the run, so that the input is kept as a finding.
inline void require(bool condition, const char* claim) {
  if (condition) return;
  std::fprintf(stderr, "broken: %s\n", claim);
  std::abort();
}

/// Writes a file with this content, for readers that take a path; it is gone at the end.
inline std::filesystem::path asFile(const std::uint8_t* data, std::size_t size, const std::string& ending = "") {
  static const struct Scratch {
    Scratch() {
      std::string name = (std::filesystem::temp_directory_path() / "spheretree_fuzz_XXXXXX").string();
      require(mkdtemp(name.data()) != nullptr, "a scratch folder can be made");
      folder = name;
    }
    ~Scratch() {
      std::error_code none;
      std::filesystem::remove_all(folder, none);
    }
    std::filesystem::path folder;
  } scratch;
  const std::filesystem::path path = scratch.folder / ("input" + ending);
  std::filesystem::remove(path);  // ext4 waits for the disk where a file is truncated and written again
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  return path;
}

}  // namespace spheretree::fuzz
