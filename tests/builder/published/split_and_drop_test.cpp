// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/split_and_drop.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "support/regions.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

FittedBall fitted(const DistanceField& field, const Vector3d& centre) { return {centre, 0, -field.signedDistance(centre)}; }

TEST(SplitAndDrop, FindsTheOctantsOfACube) {
  // Eight balls about the centres of the octants: radius sqrt(3)/4 of the side, clearance 1/4.
  const test::WholeRegion whole(test::boxMesh({0, 0, 0}, {1, 1, 1}), 2000);
  std::vector<FittedBall> balls{fitted(whole.field, {0.5, 0.5, 0.5})};
  Progress progress;
  splitAndDrop(whole.field, whole.points, balls, {8, 0, 40}, progress);
  EXPECT_EQ(balls.size(), 8u);
  EXPECT_LT(test::worstOverhang(balls), 1.03 * (std::sqrt(3.0) / 4 - 0.25));
}

TEST(SplitAndDrop, StaysWithinTheBudgetAndNeverGetsWorse) {
  for (const TriangleMesh& mesh : {test::boxMesh({-1, -2, -3}, {1, 2, 3}), test::torusMesh(5, 1, 40, 16)}) {
    const test::WholeRegion whole(mesh, 3000);
    std::vector<FittedBall> start;
    for (std::size_t i = 0; i < whole.pool.size(); i += whole.pool.size() / 40)
      start.push_back({whole.pool[i].centre, 0, whole.pool[i].clearance});
    Progress progress;
    std::vector<FittedBall> before = start;
    assignDeepest(whole.points, before);
    for (FittedBall& b : before) b.radius = std::max(b.radius, 0.0);
    double last = test::worstOverhang(before);
    for (const int rounds : {0, 1, 5, 20}) {
      std::vector<FittedBall> balls = start;
      splitAndDrop(whole.field, whole.points, balls, {start.size(), 0, rounds}, progress);
      EXPECT_LE(balls.size(), start.size());
      EXPECT_EQ(test::openShare(whole.region(8), balls), 0);
      EXPECT_LE(test::worstOverhang(balls), last * (1 + 1e-9)) << rounds << " rounds";
      last = test::worstOverhang(balls);
      for (const FittedBall& b : balls) EXPECT_NEAR(b.clearance, -whole.field.signedDistance(b.centre), 1e-9);
    }
    // More balls than allowed: the least useful ones are removed.
    for (const std::size_t max_count : {20, 7, 1}) {
      std::vector<FittedBall> balls = start;
      splitAndDrop(whole.field, whole.points, balls, {max_count, 0, 10}, progress);
      EXPECT_LE(balls.size(), max_count);
      EXPECT_EQ(test::openShare(whole.region(8), balls), 0);
    }
  }
}

TEST(SplitAndDrop, KeepsTheMostUsefulBall) {
  const test::WholeRegion whole(test::sphereMesh(2, 4), 1000);
  std::vector<FittedBall> balls{fitted(whole.field, {0, 0, 0}), fitted(whole.field, {1, 0, 0}), fitted(whole.field, {0, 0, -1.5})};
  Progress progress;
  splitAndDrop(whole.field, whole.points, balls, {1, 0, 0}, progress);
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT(balls[0].centre.norm(), 0.05);
}

TEST(SplitAndDrop, SameBallsForAnyNumberOfThreads) {
  const test::WholeRegion whole(test::torusMesh(5, 1, 40, 16), 3000);
  std::vector<std::vector<FittedBall>> results;
  for (const std::size_t threads : {1, 2, 4}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    std::vector<FittedBall> balls{fitted(whole.field, {5, 0, 0})};
    Progress progress;
    splitAndDrop(whole.field, whole.points, balls, {64, 0, 30}, progress);
    results.push_back(balls);
  }
  for (std::size_t t = 1; t < results.size(); ++t) {
    ASSERT_EQ(results[t].size(), results[0].size());
    for (std::size_t b = 0; b < results[0].size(); ++b) {
      EXPECT_EQ(results[t][b].centre, results[0][b].centre);
      EXPECT_EQ(results[t][b].radius, results[0][b].radius);
    }
  }
}

TEST(SplitAndDrop, RefusesNothing) {
  const test::WholeRegion whole(test::boxMesh({0, 0, 0}, {1, 1, 1}), 100);
  std::vector<FittedBall> none, one{fitted(whole.field, {0.5, 0.5, 0.5})};
  Progress progress;
  EXPECT_THROW(splitAndDrop(whole.field, whole.points, none, {}, progress), std::invalid_argument);
  EXPECT_THROW(splitAndDrop(whole.field, {}, one, {}, progress), std::invalid_argument);
  progress.cancel();
  EXPECT_THROW(splitAndDrop(whole.field, whole.points, one, {}, progress), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
