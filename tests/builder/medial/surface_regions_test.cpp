// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/surface_regions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "support/dense_points.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct Setting {
  TriangleMesh mesh = test::boxMesh({-1, -2, -3}, {1, 2, 3});
  DistanceField field{mesh};
  std::vector<Vector3d> points = test::densePoints(mesh, 12, 1);
  std::vector<FittedBall> balls;

  Setting() {
    test::Random random(3);
    while (balls.size() < 20) {
      const Vector3d c = random.inBox({-1, -2, -3}, {1, 2, 3});
      balls.push_back({c, 2.5, -field.signedDistance(c)});
    }
  }
};

TEST(SurfaceRegions, AssignDeepestAgreesWithBruteForce) {
  Setting s;
  const std::vector<FittedBall> before = s.balls;
  const std::vector<std::uint32_t> owner = assignDeepest(s.points, s.balls);
  for (std::size_t i = 0; i < owner.size(); ++i) {
    const Vector3d& p = s.points[i];
    double smallest = std::numeric_limits<double>::infinity();
    for (const FittedBall& b : before)
      if ((p - b.centre).norm() <= b.radius) smallest = std::min(smallest, (p - b.centre).norm() - b.clearance);
    const FittedBall& own = s.balls[owner[i]];
    EXPECT_LE((p - own.centre).norm(), own.radius * (1 + 1e-8));
    if (std::isfinite(smallest)) {
      EXPECT_NEAR((p - own.centre).norm() - own.clearance, smallest, 1e-8);
    }
  }
}

TEST(SurfaceRegions, RefitKeepsThePointsCoveredAndNeverRaisesTheWorst) {
  Setting s;
  Progress progress;
  refitBalls(s.field, s.points, s.balls, 0, progress);
  double before = 0;
  for (const FittedBall& b : s.balls) before = std::max(before, b.overhang());
  for (int round = 0; round < 4; ++round) {
    const std::vector<std::uint32_t> owner = refitBalls(s.field, s.points, s.balls, 1, progress);
    double worst = 0;
    for (const FittedBall& b : s.balls) worst = std::max(worst, b.overhang());
    EXPECT_LE(worst, before * (1 + 1e-9));
    before = worst;
    for (std::size_t i = 0; i < owner.size(); ++i)
      EXPECT_LE((s.points[i] - s.balls[owner[i]].centre).norm(), s.balls[owner[i]].radius * (1 + 1e-12));
  }
}

TEST(SurfaceRegions, HoldersAreThoseOfBruteForce) {
  Setting s;
  const Holders holders = findHolders(s.points, s.balls);
  ASSERT_EQ(holders.begin.size(), s.points.size() + 1);
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    std::vector<std::uint32_t> expected;
    for (std::uint32_t b = 0; b < s.balls.size(); ++b)
      if ((s.points[i] - s.balls[b].centre).norm() <= s.balls[b].radius * (1 + 1e-9)) expected.push_back(b);
    EXPECT_TRUE(std::ranges::equal(holders.of(i), expected)) << i;
  }
}

TEST(SurfaceRegions, RedundantBallsLeaveTheCoverComplete) {
  Setting s;
  Progress progress;
  refitBalls(s.field, s.points, s.balls, 0, progress);
  std::vector<FittedBall> balls = s.balls;
  balls.insert(balls.end(), s.balls.begin(), s.balls.end());  // every ball twice: half of them must be removed
  const std::vector<std::uint32_t> group(balls.size(), 0);
  const Holders holders = findHolders(s.points, balls);
  const std::vector<char> redundant = maybeRedundant(holders, balls, group, {}, {});
  EXPECT_GE(std::accumulate(redundant.begin(), redundant.end(), 0), static_cast<int>(s.balls.size()));
  for (const Vector3d& p : s.points) {
    bool held = false;
    for (std::size_t b = 0; b < balls.size(); ++b)
      held = held || (!redundant[b] && (p - balls[b].centre).norm() <= balls[b].radius * (1 + 1e-9));
    EXPECT_TRUE(held);
  }
  // Once one of each pair is absent, the others lose no more points than they would alone.
  std::vector<char> absent(balls.size(), 0);
  std::fill(absent.begin() + static_cast<std::ptrdiff_t>(s.balls.size()), absent.end(), 1);
  const std::vector<char> of_both = maybeRedundant(holders, balls, group, {}, absent);
  const std::vector<char> of_first = maybeRedundant(findHolders(s.points, s.balls), s.balls, group, {}, {});
  EXPECT_TRUE(std::equal(of_first.begin(), of_first.end(), of_both.begin()));
  EXPECT_EQ(std::count(of_both.begin() + static_cast<std::ptrdiff_t>(s.balls.size()), of_both.end(), 1), 0);
  std::vector<std::uint32_t> alone(balls.size());
  std::iota(alone.begin(), alone.end(), 0u);
  for (const char r : maybeRedundant(holders, balls, alone, {}, {})) EXPECT_FALSE(r) << "the last of its group";
}

// Two equal balls whose overlap contains nearly all points, but whose middles are off-centre: the plane moves until
// both have half.
TEST(SurfaceRegions, RegionsHaveEquallyManyPoints) {
  test::Random random(5);
  std::vector<Vector3d> points;
  for (int i = 0; i < 4000; ++i) points.push_back(random.inBox({0, 0, 0}, {10, 1, 1}));
  const std::vector<FittedBall> balls{{{5, 0, 0}, 20, 0}, {{9, 0, 0}, 20, 0}};
  const std::vector<std::uint32_t> owner = assignToRegions(points, balls);
  double low = 0, first = 0, second_min = 10;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (owner[i] == 0) ++first, low = std::max(low, points[i].x());
    if (owner[i] == 1) second_min = std::min(second_min, points[i].x());
  }
  EXPECT_NEAR(first / 4000, 0.5, 0.05);
  EXPECT_LE(low, second_min + 1e-9);  // a plane across x
}

}  // namespace
}  // namespace spheretree::builder
