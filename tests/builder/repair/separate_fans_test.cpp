// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/separate_fans.h"

#include <gtest/gtest.h>

#include "spheretree/builder/mesh_checks.h"
#include "spheretree/core/mesh_edit.h"
#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;
using test::soupOf;

TEST(SeparateFans, DrawsApartByTheDistanceAsked) {
  TriangleMesh both = boxMesh({0, 0, 0}, {1, 1, 1});
  const TriangleMesh other = boxMesh({1, 1, 0}, {2, 2, 1});  // one edge in common: vertices 3 and 7 there are 0 and 4 here
  both.positions.insert(both.positions.end(), other.positions.begin(), other.positions.end());
  for (const Triangle& t : other.triangles) {
    Triangle moved;
    for (std::size_t k = 0; k < 3; ++k) moved[k] = t[k] == 0 ? 3 : t[k] == 4 ? 7 : t[k] + 8;
    both.triangles.push_back(moved);
  }
  EXPECT_TRUE(checkMesh(both).has(DefectKind::NonManifoldEdge));
  RepairSoup soup = soupOf(both);
  const SeparatedFans fans = separateFans(soup, 1e-4);
  both = soup.mesh;
  dropUnusedVertices(both);
  EXPECT_EQ(fans.copies, 4u);  // both ends once more, and two vertices in the middle
  EXPECT_EQ(soup.source.size(), both.triangles.size());
  EXPECT_NEAR(fans.moved, 1e-4, 1e-12);
  EXPECT_TRUE(checkMesh(both).clean()) << checkMesh(both).summary();
  EXPECT_EQ(checkMesh(both).components.size(), 2u);
}

TEST(SeparateFans, EndsWhereTrianglesCoincide) {
  const TriangleMesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  TriangleMesh twice = box;
  twice.triangles.insert(twice.triangles.end(), box.triangles.begin(), box.triangles.end());
  RepairSoup soup = soupOf(twice);
  separateFans(soup, 1e-4);
  EXPECT_TRUE(findOpenEdges(soup.mesh).empty());
  EXPECT_LT(soup.mesh.triangles.size(), 1000000u);
}

TEST(SeparateFans, LeavesAManifoldAlone) {
  RepairSoup soup = soupOf(test::torusMesh(2, 0.5, 12, 8));
  const TriangleMesh before = soup.mesh;
  EXPECT_EQ(separateFans(soup, 1e-4).copies, 0u);
  EXPECT_EQ(soup.mesh.positions, before.positions);
  EXPECT_EQ(soup.mesh.triangles, before.triangles);
}

}  // namespace
}  // namespace spheretree::builder
