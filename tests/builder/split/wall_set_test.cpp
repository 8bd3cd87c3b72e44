// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/wall_set.h"

#include <gtest/gtest.h>

#include "support/field_surface.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// Adds a wall of one triangle above the square (-0.5, -0.5) to (0.5, 0.5), from the height `low` to `high`.
void addUpright(ScanSurface& surface, WallSet& walls, double low, double high) {
  const auto first = static_cast<std::uint32_t>(surface.mesh.positions.size());
  surface.mesh.positions.insert(surface.mesh.positions.end(), {{-0.4, -0.3, high}, {0.4, 0.3, high}, {0.1, 0.2, low}});
  walls.add({1, kGumRegion, {{first, first + 1, first + 2}}});
}

TEST(WallSet, TakesTheFirstAttemptThatCrossesNothing) {
  ScanSurface s = test::fieldOf(4, 1, [](double, double) { return 0.0; });
  const std::size_t points = s.mesh.positions.size();
  WallSet walls(s);
  std::vector<double> tried;
  const std::vector<double> lows{-1.0, -0.5, 0.5, 0.7};
  EXPECT_EQ(walls.addBest(1, lows.size(), 1,
                          [&](std::size_t i) {
                            EXPECT_EQ(s.mesh.positions.size(), points);  // nothing is left of the attempt before
                            tried.push_back(lows[i]);
                            addUpright(s, walls, lows[i], 2);
                          }),
            0u);
  EXPECT_EQ(tried, (std::vector<double>{-1.0, -0.5, 0.5}));
  EXPECT_EQ(walls.trianglesFrom(0).size(), 1u);
  EXPECT_EQ(s.mesh.positions.back().z(), 0.5);
  EXPECT_TRUE(walls.crossedTriangles().empty());
}

TEST(WallSet, LaterWallsDoNotCrossEarlierOnes) {
  ScanSurface s = test::fieldOf(4, 1, [](double, double) { return 0.0; });
  WallSet walls(s);
  walls.addBest(1, 1, 1, [&](std::size_t) { addUpright(s, walls, 1, 3); });
  const WallSet::Mark one = walls.mark();
  const auto addAcross = [&](double height) {  // crosses the first wall if it is between 1 and 3
    const auto first = static_cast<std::uint32_t>(s.mesh.positions.size());
    s.mesh.positions.insert(s.mesh.positions.end(), {{-2, 2, height}, {2, -2, height}, {2, 2, height}});
    walls.add({1, kGumRegion, {{first, first + 1, first + 2}}});
  };
  EXPECT_EQ(walls.addBest(1, 2, 1, [&](std::size_t i) { addAcross(i == 0 ? 2.5 : 3.5); }), 0u);
  EXPECT_EQ(s.mesh.positions.back().z(), 3.5);
  EXPECT_EQ(walls.mark().walls, 2u);
  EXPECT_EQ(one.walls, 1u);
}

TEST(WallSet, CountsWhatNoAttemptAvoids) {
  ScanSurface s = test::fieldOf(10, 1, [](double, double) { return 0.0; });
  const auto first = static_cast<std::uint32_t>(s.mesh.positions.size());
  s.mesh.positions.insert(s.mesh.positions.end(), {{-0.4, -0.3, 2}, {0.4, 0.3, 2}, {0.1, 0.2, -2}});  // fixed, on both sides of the field
  WallSet walls(s);
  const WallSet::Mark begin = walls.mark();
  EXPECT_GT(walls.addBest(1, 2, 1, [&](std::size_t) { walls.add({1, kGumRegion, {{first, first + 1, first + 2}}}); }), 0u);
  EXPECT_GE(walls.trianglesFrom(0).size(), 1u);
  const std::vector<std::uint32_t> crossed = walls.crossedTriangles();
  ASSERT_FALSE(crossed.empty());
  for (const std::uint32_t t : crossed) EXPECT_LT(t, s.mesh.triangles.size());
  walls.undoTo(begin);
  EXPECT_TRUE(walls.crossedTriangles().empty());
  EXPECT_TRUE(walls.takeWalls().empty());
  EXPECT_EQ(s.mesh.positions.size(), first + 3u);
}

}  // namespace
}  // namespace spheretree::builder
