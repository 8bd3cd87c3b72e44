// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/swept_burr.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

double distanceFrom(std::span<const Capsule> capsules, const Vector3d& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Capsule& capsule : capsules) least = std::min(least, (p - nearestOnAxis(capsule, p)).norm());
  return least;
}

TEST(SweptBurr, OfTwoBallsIsACapsuleForEachStep) {
  const std::array paths{BurrPath{0.5, {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}}, BurrPath{0.2, {{5, 0, 0}, {5, 0, 0}}}};
  const std::vector<Capsule> capsules = sweptCapsules(paths, 0);
  ASSERT_EQ(capsules.size(), 3u);
  EXPECT_EQ(capsules[1].from, Vector3d(1, 0, 0));
  EXPECT_EQ(capsules[1].to, Vector3d(1, 1, 0));
  EXPECT_EQ(capsules[2].radius, 0.2);
  EXPECT_EQ(nearestOnAxis(capsules[0], {0.3, 2, 0}), Vector3d(0.3, 0, 0));
  EXPECT_EQ(nearestOnAxis(capsules[0], {-2, 2, 0}), Vector3d(0, 0, 0));
  EXPECT_EQ(nearestOnAxis(capsules[2], {9, 0, 0}), Vector3d(5, 0, 0));
}

// The path and the axes are within the slack of each other, on any path, also one that rests, turns back or shakes.
TEST(SweptBurr, WithSlackHasFewerCapsulesThatStayNear) {
  test::Random random(4);
  for (const double slack : {0.001, 0.02}) {
    BurrPath path{0.5, {Vector3d::Zero()}};
    Vector3d way = Vector3d::UnitX();
    for (int n = 0; n < 3000; ++n) {
      if (random.below(200) == 0) way = random.below(3) == 0 ? Vector3d(0, 0, 0) : random.direction();
      path.centres.push_back(path.centres.back() + 0.004 * way + 0.0003 * random.direction());
    }
    const std::vector<Capsule> capsules = sweptCapsules(std::array{path}, slack), steps = sweptCapsules(std::array{path}, 0);
    EXPECT_LT(capsules.size(), steps.size() / 2) << slack;
    for (const Vector3d& p : path.centres) ASSERT_LE(distanceFrom(capsules, p), slack + 1e-12);
    for (const Capsule& capsule : capsules)
      for (int k = 0; k <= 4; ++k) ASSERT_LE(distanceFrom(steps, capsule.from + 0.25 * k * (capsule.to - capsule.from)), slack + 1e-12);
    EXPECT_EQ(capsules.front().from, path.centres.front());
    EXPECT_EQ(capsules.back().to, path.centres.back());
  }
}

}  // namespace
}  // namespace spheretree::builder
