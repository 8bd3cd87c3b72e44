// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_overhang.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A capsule in a box reaches out of its nearest face by a length that is known.
TEST(HullOverhang, OfAConeInABoxIsExact) {
  const DistanceField field(test::boxMesh({0, 0, 0}, {20, 4, 4}));
  const Hull cone{{Ball{{3, 2, 2}, 2.1}, Ball{{17, 2, 2}, 1.5}, {}}, 2};
  const HullOverhang o = hullOverhang(field, cone, {.absolute = 1e-6});
  EXPECT_NEAR(o.attained, 0.1, 1e-9);
  EXPECT_GE(o.bound, o.attained);
  EXPECT_LE(o.bound, 1.001 * o.attained + 1e-9);
}

// Over random hulls: the bound holds for many balls of the hull, and is near the largest of them.
TEST(HullOverhang, BoundsManyBallsOfTheHull) {
  const DistanceField field(test::sphereMesh(3, 3));
  test::Random random(11);
  for (int round = 0; round < 40; ++round) {
    Hull hull;
    hull.count = 2 + static_cast<std::size_t>(round) % 2;
    for (Ball& ball : hull.ball) ball = {random.inCube(1.5), random.between(0.3, 1.5)};
    const HullOverhang o = hullOverhang(field, hull, {.absolute = 1e-4});
    double largest = -kInfinity;
    for (int i = 0; i <= 100; ++i)
      for (int j = 0; j <= (hull.count == 3 ? 100 - i : 0); ++j) {
        const double w1 = 0.01 * i, w2 = 0.01 * j, w0 = 1 - w1 - w2;
        const auto& [a, b, c] = hull.ball;
        largest = std::max(
            largest, w0 * a.radius + w1 * b.radius + w2 * c.radius + field.signedDistance(w0 * a.centre + w1 * b.centre + w2 * c.centre));
      }
    EXPECT_GE(o.bound, largest);
    EXPECT_LE(o.attained, largest + 0.05) << "of a ball of the hull";
    EXPECT_LE(o.bound, std::max({0.0, 1.001 * o.attained, o.attained + 1e-4}) + 1e-9) << "below 0 nothing has to be known";
  }
}

TEST(HullOverhang, EndsOnceTheLimitIsPassed) {
  const DistanceField field(test::sphereMesh(1, 2));
  const Hull cone{{Ball{{0, 0, 0}, 1}, Ball{{8, 0, 0}, 1}, {}}, 2};
  EXPECT_GT(hullOverhang(field, cone, {.limit = 0.5}).attained, 0.5);
}

}  // namespace
}  // namespace spheretree::builder
