// SPDX-License-Identifier: Apache-2.0
#include "gltf/glb_writer.h"

#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "support/scratch_folder.h"

namespace spheretree::formats {
namespace {

GlbWriter::Part tetrahedron(const std::string& name, double size) {
  GlbWriter::Part part;
  part.name = name;
  part.colour = {0.1, 0.2, 0.3};
  part.positions = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size}};
  part.normals.assign(4, Eigen::Vector3d::UnitZ());
  part.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return part;
}

std::vector<std::byte> twoPartGlb() {
  GlbWriter glb;
  const int small = glb.add(tetrahedron("small", 10)), large = glb.add(tetrahedron("large", 20));
  glb.addScene("both", {glb.addNode("root", {small, large}, {1000, 0, 0})});
  glb.addScene("one", {small});
  return glb.finish();
}

nlohmann::json documentOf(const std::vector<std::byte>& bytes) {
  std::uint32_t size = 0;
  std::memcpy(&size, bytes.data() + 12, 4);
  return nlohmann::json::parse(reinterpret_cast<const char*>(bytes.data()) + 20, reinterpret_cast<const char*>(bytes.data()) + 20 + size);
}

TEST(GlbWriter, OurOwnReaderGetsTheMeshBack) {  // which shares no code with it
  const test::ScratchFolder folder;
  writeWhole(folder.path() / "two.glb", twoPartGlb());
  const MeshFile file = readMesh(folder.path() / "two.glb");
  ASSERT_EQ(file.mesh.part_names.size(), 2u);
  EXPECT_EQ(file.mesh.triangles.size(), 8u);
  double smallest = 1e9, largest = -1e9;
  for (const Eigen::Vector3d& p : file.mesh.positions) smallest = std::min(smallest, p.x()), largest = std::max(largest, p.x());
  EXPECT_NEAR(smallest, 1000, 1e-3) << "the origin of the node, through metres and back";
  EXPECT_NEAR(largest, 1020, 1e-3);
}

TEST(GlbWriter, SameCallsSameBytes) { EXPECT_EQ(twoPartGlb(), twoPartGlb()); }

TEST(GlbWriter, SaysTheLimitsOfItsPositionsAndTheSceneToShow) {
  const nlohmann::json document = documentOf(twoPartGlb());
  EXPECT_EQ(document["scene"], 0);
  EXPECT_EQ(document["scenes"][0]["name"], "both");
  const std::size_t positions = document["meshes"][1]["primitives"][0]["attributes"]["POSITION"];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(document["accessors"][positions]["min"][axis].get<double>(), 0, 1e-12);
    EXPECT_NEAR(document["accessors"][positions]["max"][axis].get<double>(), 0.02, 1e-9);
  }
  EXPECT_EQ(document["buffers"].size(), 1u);
}

TEST(GlbWriter, AnEmptySceneIsAValidFile) {
  GlbWriter glb;
  glb.addScene("empty", {});
  const std::vector<std::byte> bytes = glb.finish();
  EXPECT_EQ(documentOf(bytes)["scenes"].size(), 1u);
  EXPECT_EQ(bytes.size() % 4, 0u);
}

}  // namespace
}  // namespace spheretree::formats
