// SPDX-License-Identifier: Apache-2.0
// Feeds any bytes to the reader of OBJ files.
#include "spheretree/formats/obj.h"

#include "fuzz/mesh_fuzz.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  return {"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1/1 2/2 4/3\ng a b\nf 1// 4// 3//\no c#d\nf -3 -2 -1\n",
          "\xef\xbb\xbf# x\r\nv 1e-3 +2.5 -.5 0.1 0.2 0.3\r\nf 1 2 3 \\\r\n 4\r\nv 1 0 0\r\nv 1 1 0\r\nv 0.4 0.5 0\r\nl 1 2\r\n",
          "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nv nan 1 1e999\nf 1 2 3 4 5\ncurv 0 1 1 2\ns off\nusemtl x\n"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spheretree::fuzz::feedMesh(data, size, [](auto bytes, const std::string& name) { return spheretree::formats::readObj(bytes, name); });
  return 0;
}
