// SPDX-License-Identifier: Apache-2.0
// Feeds any bytes to the reader of STL files.
#include "spheretree/formats/stl.h"

#include "fuzz/mesh_fuzz.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  std::string binary(80, 0);
  binary += std::string("\2\0\0\0", 4);
  for (int facet = 0; facet < 2; ++facet) {
    binary += std::string(12, 0);
    for (char corner = 0; corner < 9; ++corner) binary += std::string("\0\0", 2) + static_cast<char>(corner * 7 + facet) + "\x3f";
    binary += std::string(2, 0);
  }
  return {binary,
          "solid a b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a b\n"
          "solid c\nFACET\nVERTEX 1 2 3e1 VERTEX 4 5 6 vertex 7 8 -9 ENDFACET\nendsolid\n"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spheretree::fuzz::feedMesh(data, size, [](auto bytes, const std::string& name) { return spheretree::formats::readStl(bytes, name); });
  return 0;
}
