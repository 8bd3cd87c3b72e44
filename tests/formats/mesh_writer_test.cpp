// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/mesh_writer.h"

#include <gtest/gtest.h>

#include "spheretree/formats/obj.h"
#include "spheretree/formats/ply.h"

namespace spheretree::formats {
namespace {

TriangleMesh twoParts() {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1.0 / 3, 0, 0}, {0, 1e-9, 0}, {0, 0, 12345.6789}, {1, 2, 3}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 4}};
  mesh.part = {0, 0, 1};
  mesh.part_names = {"left", "right"};
  return mesh;
}

std::span<const char> charsOfBytes(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(MeshWriter, PlyReadsBackTheSame) {
  const TriangleMesh mesh = twoParts(), back = readPly(charsOfBytes(encodePly(mesh)), "a.ply", 1).mesh;
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.triangles, mesh.triangles);
}

TEST(MeshWriter, ObjReadsBackTheSameWithItsParts) {
  const TriangleMesh mesh = twoParts(), back = readObj(charsOfBytes(encodeObj(mesh)), "a.obj", 1).mesh;
  EXPECT_EQ(back.positions, mesh.positions);
  EXPECT_EQ(back.triangles, mesh.triangles);
  EXPECT_EQ(back.part_names, mesh.part_names);
  EXPECT_EQ(back.part, mesh.part);
}

}  // namespace
}  // namespace spheretree::formats
