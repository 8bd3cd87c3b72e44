// SPDX-License-Identifier: Apache-2.0
// Feeds any bytes to the reader of OFF files.
#include "spheretree/formats/off.h"

#include "fuzz/mesh_fuzz.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  return {"OFF\n4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2 255 0 0\n3 1 2 3\n",
          "# x\n  COFF4 2 0 # y\n0 0 0 1 1 1\n1 0 0 0.5\n1 1 0\n.3 .4 0\n4 0 1 2 3\n3 0 1 2\n", "3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spheretree::fuzz::feedMesh(data, size, [](auto bytes, const std::string& name) { return spheretree::formats::readOff(bytes, name); });
  return 0;
}
