// SPDX-License-Identifier: Apache-2.0
// Feeds any bytes to the reader of PLY files.
#include "spheretree/formats/ply.h"

#include "fuzz/mesh_fuzz.h"

namespace spheretree::fuzz {

std::vector<std::string> seeds() {
  const std::string properties = "property float x\nproperty float y\nproperty float z\n";
  const std::string places(
      "\0\0\0\0\0\0\0\0\0\0\0\0"
      "\0\0\x80\x3f\0\0\0\0\0\0\0\0"
      "\0\0\0\0\0\0\x80\x3f\0\0\0\0",
      36);
  return {"ply\nformat ascii 1.0\ncomment x\nelement vertex 4\n" + properties +
              "element face 2\nproperty list uchar int vertex_indices\nproperty uchar red\nend_header\n"
              "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1 255\n4 0 1 3 2 0 9\n",
          "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
          "element face 1\r\nproperty list ushort uchar vertex_index\r\nend_header\r\n" +
              places + std::string("\3\0\0\1\2", 5),
          "ply\nformat binary_big_endian 1.0\nelement vertex 3\n" + properties +
              "property list char double w\nelement face 1\nproperty list int short vertex_indices\nelement e 2\nproperty int8 "
              "a\nend_header\n" +
              std::string(12, 0) + "\1" + std::string(8, 1) + std::string(12, 2) + std::string(1, 0) + std::string(12, 3) +
              std::string(1, 0) + std::string("\0\0\0\3\0\0\0\1\0\2\7\7", 12)};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  spheretree::fuzz::feedMesh(data, size, [](auto bytes, const std::string& name) { return spheretree::formats::readPly(bytes, name); });
  return 0;
}
