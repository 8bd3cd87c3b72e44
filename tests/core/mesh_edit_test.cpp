// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/mesh_edit.h"

#include <gtest/gtest.h>

namespace spheretree {
namespace {

using Eigen::Vector3d;

TEST(MeshEdit, DropsUnusedVerticesAndKeepsTheOrderOfTheOthers) {
  TriangleMesh mesh;
  for (int i = 0; i < 6; ++i) mesh.positions.emplace_back(i, 0, 0);
  mesh.triangles = {{5, 1, 3}, {3, 1, 4}};
  dropUnusedVertices(mesh);
  EXPECT_EQ(mesh.positions, (std::vector<Vector3d>{{1, 0, 0}, {3, 0, 0}, {4, 0, 0}, {5, 0, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{3, 0, 1}, {1, 0, 2}}));
  mesh.triangles.clear();
  dropUnusedVertices(mesh);
  EXPECT_TRUE(mesh.positions.empty());
}

TEST(MeshEdit, WeldsEqualVerticesToTheFirstOfThem) {
  TriangleMesh mesh;
  mesh.positions = {{9, 9, 9}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 0}};
  mesh.triangles = {{1, 2, 3}, {4, 5, 6}, {7, 5, 1}};
  EXPECT_EQ(weldEqualVertices(mesh), (std::vector<std::uint32_t>{kNone, 0, 1, 2, 1, 3, 2, 0}));
  EXPECT_EQ(mesh.positions, (std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 3, 2}, {0, 3, 0}}));
  EXPECT_EQ(weldEqualVertices(mesh), (std::vector<std::uint32_t>{0, 1, 2, 3}));
  EXPECT_EQ(mesh.positions.size(), 4u);
}

TEST(MeshEdit, JoinsWithoutParts) {
  TriangleMesh a{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {0}, {"a"}};
  const TriangleMesh both = joined(a, a);
  EXPECT_EQ(both.positions.size(), 6u);
  EXPECT_EQ(both.triangles, (std::vector<Triangle>{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_TRUE(both.part.empty() && both.part_names.empty());
}

}  // namespace
}  // namespace spheretree
