// SPDX-License-Identifier: Apache-2.0
// The interface of a fuzz target: the entry of libFuzzer, and valid inputs to start from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
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

}  // namespace spheretree::fuzz
