// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/hull.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

double byManyBalls(const Hull& hull, const Vector3d& p) {
  constexpr int kSteps = 200;
  double nearest = kInfinity;
  for (int i = 0; i <= (hull.count > 1 ? kSteps : 0); ++i)
    for (int j = 0; j <= (hull.count == 3 ? kSteps - i : 0); ++j) {
      const double w1 = i / double{kSteps}, w2 = j / double{kSteps}, w0 = 1 - w1 - w2;
      const auto& [a, b, c] = hull.ball;
      const Vector3d centre = w0 * a.centre + w1 * b.centre + w2 * c.centre;
      nearest = std::min(nearest, (p - centre).norm() - w0 * a.radius - w1 * b.radius - w2 * c.radius);
    }
  return nearest;
}

TEST(HullDistance, AgreesWithManyBallsAlongTheHull) {
  test::Random random(3);
  for (int round = 0; round < 60; ++round) {
    Hull hull;
    hull.count = 1 + static_cast<std::size_t>(round) % 3;
    for (Ball& ball : hull.ball) ball = {random.inCube(1), random.between(0.1, round % 2 ? 0.3 : 1.5)};
    const HullDistance distance(hull);
    for (int i = 0; i < 20; ++i) {
      const Vector3d p = random.inCube(2);
      const double brute = byManyBalls(hull, p);
      EXPECT_LE(distance(p), brute + 1e-12);
      EXPECT_GE(distance(p), brute - 0.02) << "one of the balls is within half a step";
    }
  }
}

TEST(HullDistance, ConeAndSlabInClosedForm) {
  // A cone with the slope 0.6: its side makes an angle of sine 0.6 with the axis.
  const Hull cone{{Ball{{0, 0, 0}, 1}, Ball{{0, 0, 10}, 7}, {}}, 2};
  EXPECT_DOUBLE_EQ(steepness(cone), 0.6);
  EXPECT_NEAR(HullDistance(cone)({10, 0, 0}), 10 * 0.8 - 1, 1e-12) << "perpendicular to the side, whose foot is inside";
  EXPECT_NEAR(HullDistance(cone)({0, 0, -4}), 3, 1e-12);
  const Hull slab{{Ball{{0, 0, 0}, 0.5}, Ball{{4, 0, 0}, 0.5}, Ball{{0, 4, 0}, 0.5}}, 3};
  EXPECT_DOUBLE_EQ(steepness(slab), 0);
  EXPECT_NEAR(HullDistance(slab)({1, 1, -2}), 1.5, 1e-12);
  EXPECT_NEAR(HullDistance(slab)({1, -3, 0}), 2.5, 1e-12) << "beyond a side";
  EXPECT_NEAR(HullDistance(slab)({-3, -4, 0}), 4.5, 1e-12) << "beyond a corner";
  EXPECT_TRUE(HullDistance(slab).holds({{1, 1, 0.2}, 0.3}));
  EXPECT_FALSE(HullDistance(slab).holds({{1, 1, 0.2}, 0.301}));
}

TEST(HullDistance, ABallThatHoldsTheOthersIsTheHull) {
  const Hull hull{{Ball{{0, 0, 0}, 3}, Ball{{1, 0, 0}, 1}, Ball{{0, 1, 0}, 1}}, 3};
  test::Random random(5);
  for (int i = 0; i < 100; ++i) {
    const Vector3d p = random.inCube(6);
    EXPECT_NEAR(HullDistance(hull)(p), p.norm() - 3, 1e-12);
  }
}

}  // namespace
}  // namespace spheretree::builder
