// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/region_borders.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/field_surface.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// Number of vertices at which an arc of the loop ends; checks that the loop is closed.
int nodesOf(const RegionBorders& borders, const std::vector<BorderEdge>& loop) {
  int nodes = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const BorderEdge& before = loop[(i + loop.size() - 1) % loop.size()];
    EXPECT_EQ(before.to, loop[i].from);
    nodes += borders.isNode(before, loop[i]);
  }
  return nodes;
}

TEST(RegionBorders, TwoNeighboursShareAnArcBetweenTwoNodes) {
  ScanSurface s = test::fieldOf(4, 1, [](double, double) { return 0.0; });
  test::addRegion(s, [](const Vector3d& p) { return p.x() > -2 && p.x() < 0 && std::abs(p.y()) < 2; });
  test::addRegion(s, [](const Vector3d& p) { return p.x() > 0 && p.x() < 2 && std::abs(p.y()) < 2; });
  const RegionBorders borders(s);
  ASSERT_EQ(borders.regionCount(), 3);
  for (const std::int32_t region : {1, 2}) {
    const auto loops = borders.loopsOf(region);
    ASSERT_EQ(loops.size(), 1u);
    EXPECT_EQ(loops[0].size(), 12u);
    EXPECT_EQ(loops[0].size(), borders.edgesOf(region).size());
    EXPECT_EQ(std::count_if(loops[0].begin(), loops[0].end(), [&](const BorderEdge& e) { return e.other == 3 - region; }), 4);
    EXPECT_EQ(nodesOf(borders, loops[0]), 2);
  }
}

TEST(RegionBorders, PiecesThatTouchInAVertexHaveLoopsOfTheirOwn) {
  ScanSurface s = test::fieldOf(4, 1, [](double, double) { return 0.0; });
  test::addRegion(s, [](const Vector3d& p) { return p.head<2>().cwiseAbs().maxCoeff() < 2 && p.x() * p.y() > 0; });
  const RegionBorders borders(s);
  const auto loops = borders.loopsOf(1);
  ASSERT_EQ(loops.size(), 2u);
  for (const auto& loop : loops) {
    EXPECT_EQ(loop.size(), 8u);
    EXPECT_EQ(nodesOf(borders, loop), 1);  // where they touch
  }
}

}  // namespace
}  // namespace spheretree::builder
