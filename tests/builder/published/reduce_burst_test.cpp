// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_burst.h"

#include <gtest/gtest.h>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

TEST(ReduceBurst, CoversWithFewBallsAndIsPure) { test::expectReduces(reduceBurst); }

TEST(ReduceBurst, NothingToStartFrom) {
  const test::WholeRegion whole(test::boxMesh({-1, -2, -3}, {1, 2, 3}), 100);
  Region region = whole.region(8);
  region.pool = {};
  EXPECT_TRUE(reduceBurst(region).empty());
}

TEST(ReduceBurst, OneBallHasNothingToBurstInto) {
  const test::WholeRegion whole(test::sphereMesh(2, 3), 100);
  const std::vector<FittedBall> one{whole.pool[0]};
  Region region = whole.region(8);
  region.pool = one;
  EXPECT_EQ(reduceBurst(region).size(), 1u);
}

TEST(ReduceBurst, JoinsPartsThatNoNeighboursLink) {
  const test::WholeRegion whole(test::joined(test::sphereMesh(1, 2),
                                             [] {
                                               TriangleMesh far = test::sphereMesh(1, 2);
                                               for (Eigen::Vector3d& p : far.positions) p.x() += 50;
                                               return far;
                                             }()),
                                200);
  EXPECT_LT(test::worstOverhang(reduceBurst(whole.region(2))), 0.3);  // one ball each
  EXPECT_EQ(reduceBurst(whole.region(1)).size(), 1u);
}
}  // namespace
}  // namespace spheretree::builder
