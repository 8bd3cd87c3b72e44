// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_expand.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

TEST(ReduceExpand, CoversWithFewBallsAndIsPure) { test::expectReduces(reduceExpand); }

TEST(ReduceExpand, OneBallForASphere) {
  const test::WholeRegion whole(test::sphereMesh(2, 4), 500);
  const std::vector<FittedBall> balls = reduceExpand(whole.region(1));
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT(balls[0].overhang(), 0.02);  // the error of the facets: the mesh lies within 0.01 mm of the sphere
  EXPECT_LT(balls[0].centre.norm(), 0.02);
}

TEST(ReduceExpand, NothingToStartFrom) {
  const test::WholeRegion whole(test::boxMesh({-1, -2, -3}, {1, 2, 3}), 100);
  Region region = whole.region(8);
  region.pool = {};
  EXPECT_TRUE(reduceExpand(region).empty());
}

// The paper uses one stand-off for all balls: every ball is its medial ball, grown by the same length.
TEST(ReduceExpand, OneStandOffForAll) {
  const test::WholeRegion whole(test::torusMesh(5, 1, 40, 16), 600);
  const std::vector<FittedBall> balls = reduceExpand(whole.region(8));
  for (const FittedBall& b : balls) EXPECT_NEAR(b.overhang(), balls[0].overhang(), 1e-12);
}

TEST(ReduceExpand, FindsTheSmallestStandOffOfACoverByBruteForce) {
  // Four balls on a line, points at known distances: with two balls allowed the best pair is found by trying all.
  const test::WholeRegion whole(test::boxMesh({-8, -1, -1}, {8, 1, 1}), 300);
  std::vector<FittedBall> pool;
  for (const double x : {-6.0, -3.5, 0.5, 4.0, 6.5}) pool.push_back({Eigen::Vector3d(x, 0, 0), 1, 1});
  Region region = whole.region(2);
  region.pool = pool;
  double best = std::numeric_limits<double>::infinity();
  for (const FittedBall& a : pool)
    for (const FittedBall& b : pool) {
      double need = 0;
      for (const Eigen::Vector3d& p : region.points) need = std::max(need, std::min((p - a.centre).norm(), (p - b.centre).norm()) - 1);
      best = std::min(best, need);
    }
  const double found = test::worstOverhang(reduceExpand(region));
  EXPECT_GE(found, best * (1 - 1e-6));
  EXPECT_LE(found, best * 2);  // greedy: the ball that covers the most points may not belong to the best pair
}
}  // namespace
}  // namespace spheretree::builder
