// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/separate_fans.h"

#include <gtest/gtest.h>

#include <algorithm>

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

TEST(SeparateFans, LeavesCoincidentTrianglesAlone) {
  const TriangleMesh box = boxMesh({0, 0, 0}, {1, 1, 1});
  TriangleMesh twice = box;
  twice.triangles.insert(twice.triangles.end(), box.triangles.begin(), box.triangles.end());
  RepairSoup soup = soupOf(twice);
  EXPECT_EQ(separateFans(soup, 1e-4).copies, 0u);
  EXPECT_EQ(soup.mesh.triangles, twice.triangles);
}

// A board of cubes that touch along edges: nearly every triangle has two or three shared sides.
TEST(SeparateFans, MakesAtMostFourOfATriangle) {
  constexpr int kSide = 6;
  TriangleMesh board;
  const auto vertexAt = [&](const Vector3d& p) {
    const auto at = std::ranges::find(board.positions, p);
    if (at != board.positions.end()) return static_cast<std::uint32_t>(at - board.positions.begin());
    board.positions.push_back(p);
    return static_cast<std::uint32_t>(board.positions.size() - 1);
  };
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const Vector3d low(i % kSide, i / kSide % kSide, i / kSide / kSide);
    if (static_cast<int>(low.sum()) % 2) continue;
    const TriangleMesh cube = boxMesh(low, low + Vector3d(1, 1, 1));
    for (const auto& [a, b, c] : cube.triangles)
      board.triangles.push_back({vertexAt(cube.positions[a]), vertexAt(cube.positions[b]), vertexAt(cube.positions[c])});
  }
  RepairSoup soup = soupOf(board);
  separateFans(soup, 1e-4);
  EXPECT_GT(soup.mesh.triangles.size(), 2 * board.triangles.size());
  EXPECT_LE(soup.mesh.triangles.size(), 4 * board.triangles.size());
  TriangleMesh apart = soup.mesh;
  dropUnusedVertices(apart);
  EXPECT_TRUE(checkMesh(apart).clean()) << checkMesh(apart).summary();
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
