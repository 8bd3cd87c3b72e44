// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_merge.h"

#include <gtest/gtest.h>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

TEST(ReduceMerge, CoversWithFewBallsAndIsPure) { test::expectReduces(reduceMerge); }

TEST(ReduceMerge, OneBallForASphere) {
  const test::WholeRegion whole(test::sphereMesh(2, 4), 500);
  const std::vector<FittedBall> balls = reduceMerge(whole.region(1));
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT(balls[0].overhang(), 0.02);  // the error of the facets: the mesh lies within 0.01 mm of the sphere
  EXPECT_LT(balls[0].centre.norm(), 0.02);
}

TEST(ReduceMerge, NothingToStartFrom) {
  const test::WholeRegion whole(test::boxMesh({-1, -2, -3}, {1, 2, 3}), 100);
  Region region = whole.region(8);
  region.pool = {};
  EXPECT_TRUE(reduceMerge(region).empty());
}
}  // namespace
}  // namespace spheretree::builder
