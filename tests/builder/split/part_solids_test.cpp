// SPDX-License-Identifier: GPL-3.0-or-later
// The walls that divide the inside of a scan. Known answers for a field of heights.
#include "split/part_solids.h"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/crossing_triangles.h"
#include "split/close_scan.h"
#include "support/field_surface.h"
#include "support/mesh_measures.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TEST(FindWalls, TheSolidsFillTheInside) {
  const auto bump = [](double x, double y) { return std::max(0.0, 1 - std::abs(x) / 3) * std::max(0.0, 1 - std::abs(y) / 3) * 2; };
  ScanSurface s = test::fieldOf(6, 0.25, bump);
  test::addRegion(s, [](const Vector3d& p) { return p.head<2>().cwiseAbs().maxCoeff() < 3; });  // its rim: a square of 6 mm, flat
  const double tooth_volume = test::volumeUnder(s.mesh, [&](std::size_t t) { return s.region[t] == 1; });
  addBase(s, Vector3d::UnitZ(), 4);
  const double whole = test::volumeOf(s.mesh);
  const PartSolids solids = findWalls(s, {Vector3d::UnitZ(), 0});
  std::vector<char> invented;
  const TriangleMesh tooth = solidOf(s, solids, 1, invented), gum = solidOf(s, solids, kGumRegion, invented);
  for (const TriangleMesh& part : {tooth, gum}) {
    EXPECT_TRUE(test::isClosed(part));
    EXPECT_EQ(findCrossingTriangles(part, 1).pairs.size(), 0u);
  }
  EXPECT_NEAR(test::volumeOf(tooth) + test::volumeOf(gum), whole, 1e-9 * whole);
  // The cap is flat, half an edge of 0.25 mm below the rim.
  EXPECT_NEAR(test::volumeOf(tooth), tooth_volume + 36 * 0.125, 0.05 * 36 * 0.125);
  ASSERT_EQ(solids.rim_length.size(), 2u);
  EXPECT_NEAR(solids.rim_length[1], 24, 1e-9);
}

}  // namespace
}  // namespace spheretree::builder
