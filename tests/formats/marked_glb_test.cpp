// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/marked_glb.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "spheretree/formats/gltf.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"

namespace spheretree::formats {
namespace {

MeshFile readBack(const std::vector<std::byte>& bytes) {
  return readGltf(std::span<const char>(reinterpret_cast<const char*>(bytes.data()), bytes.size()), "marked.glb");
}

TEST(MarkedGlb, IsReadAsTheSameMeshInParts) {
  const TriangleMesh box = test::boxMesh({0, 0, 0}, {2, 2, 2});
  const std::vector<Marks> marks{{"border", {1, 0, 0}, {1, 2}, {}}, {"fold", {0, 1, 0}, {2, 5}, {}}, {"nothing", {0, 0, 1}, {}, {}}};
  const MeshFile file = readBack(encodeMarkedGlb(box, marks));
  EXPECT_EQ(file.mesh.triangles.size(), 12u);
  EXPECT_EQ(file.mesh.part_names, (std::vector<std::string>{"mesh", "border", "fold"}));
  EXPECT_NEAR(test::volumeOf(file.mesh), 8, 1e-5);
  std::array<int, 3> count{};
  for (const std::uint32_t part : file.mesh.part) ++count.at(part);
  EXPECT_EQ(count, (std::array<int, 3>{9, 2, 1})) << "the first mark has triangle 2";
}

// A viewer shows the colours; linear 0.25 is 128 in sRGB.
TEST(MarkedGlb, TheColoursComeBack) {
  const TriangleMesh box = test::boxMesh({0, 0, 0}, {2, 2, 2});
  const MeshFile file = readBack(encodeMarkedGlb(box, std::vector<Marks>{{"border", {1, 0.25, 0}, {1, 2}, {}}}));
  ASSERT_EQ(file.colours.size(), file.mesh.triangles.size());
  for (std::size_t t = 0; t < file.colours.size(); ++t)
    EXPECT_EQ(file.colours[t] == (std::array<std::uint8_t, 3>{255, 128, 0}), file.mesh.part_names[file.mesh.part[t]] == "border") << t;
  EXPECT_TRUE(readBack(encodeMarkedGlb(box, {})).colours.empty()) << "one colour distinguishes nothing";
}

TEST(MarkedGlb, APointIsASmallOctahedronWoundOutward) {
  const TriangleMesh box = test::boxMesh({0, 0, 0}, {2, 2, 2});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const TriangleMesh mesh = readBack(encodeMarkedGlb(box, std::vector<Marks>{{"p", {1, 0, 0}, {}, {{1, 1, 5}, {nan, 0, 0}}}})).mesh;
  ASSERT_EQ(mesh.triangles.size(), 20u);
  const double r = 0.004 * std::sqrt(12.0);
  EXPECT_NEAR(test::volumeOf(mesh) - 8, 4.0 / 3 * r * r * r, 2e-6) << "turned inward it would be less by twice that";
}

TEST(MarkedGlb, BrokenTrianglesAreLeftOut) {
  TriangleMesh box = test::boxMesh({0, 0, 0}, {2, 2, 2});
  box.triangles[3][0] = 77;
  EXPECT_EQ(readBack(encodeMarkedGlb(box, {})).mesh.triangles.size(), 11u);
}

}  // namespace
}  // namespace spheretree::formats
