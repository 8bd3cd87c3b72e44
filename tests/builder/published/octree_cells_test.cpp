// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/octree_cells.h"

#include <gtest/gtest.h>

#include <vector>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

double areaOf(const OctreeCell& cell) {
  double area = 0;
  for (const Polygon& piece : cell.pieces)
    for (std::size_t i = 2; i < piece.size(); ++i) area += 0.5 * (piece[i - 1] - piece[0]).cross(piece[i] - piece[0]).norm();
  return area;
}

TEST(OctreeCells, HalvesShareTheSurface) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 30, 12);
  const DistanceField field(mesh);
  std::vector<OctreeCell> cells{rootCell(mesh, field)};
  const double area = areaOf(cells[0]);
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<OctreeCell> halves;
    for (const OctreeCell& cell : cells)
      for (OctreeCell& half : halve(cell, axis)) halves.push_back(half);
    cells = halves;
    double sum = 0;
    for (const OctreeCell& cell : cells) {
      sum += areaOf(cell);
      for (const Polygon& piece : cell.pieces)
        for (const Eigen::Vector3d& p : piece) EXPECT_LE(cell.box.exteriorDistance(p), 1e-12);
    }
    EXPECT_NEAR(sum, area, 1e-12 * area);
  }
  EXPECT_EQ(cells.size(), 8u);
}

TEST(OctreeCells, APieceInThePlaneOfTheCutBelongsToOneHalf) {
  OctreeCell cell;
  cell.box = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 2, 2)};
  cell.pieces = {{{0, 0, 1}, {2, 0, 1}, {0, 2, 1}}};
  ASSERT_EQ(halve(cell, 2).size(), 1u);
  EXPECT_EQ(halve(cell, 2)[0].pieces.size(), 1u);
}

}  // namespace
}  // namespace spheretree::builder
