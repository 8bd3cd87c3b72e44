// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_hubbard.h"

#include <gtest/gtest.h>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

TEST(ReduceHubbard, CoversWithFewBallsAndIsPure) { test::expectReduces(reduceHubbard); }

TEST(ReduceHubbard, OneBallForASphere) {
  const test::WholeRegion whole(test::sphereMesh(2, 4), 500);
  const std::vector<FittedBall> balls = reduceHubbard(whole.region(1));
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT(balls[0].overhang(), 0.02);  // the error of the facets: the mesh lies within 0.01 mm of the sphere
  EXPECT_LT(balls[0].centre.norm(), 0.02);
}

}  // namespace
}  // namespace spheretree::builder
