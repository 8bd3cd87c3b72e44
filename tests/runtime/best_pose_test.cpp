// SPDX-License-Identifier: Apache-2.0
#include "piece/best_pose.h"

#include <gtest/gtest.h>

namespace spheretree::runtime {
namespace {

Configuration at(double x) { return {{x, 0, 0}, {1, 0, 0, 0}}; }

TEST(BestPose, KeepsTheSmallestDepth) {
  BestPose best;
  EXPECT_FALSE(best.isKnown());
  best.record(at(1), 0.5);
  best.record(at(2), 0.25);
  best.record(at(3), 0.75);
  EXPECT_TRUE(best.isKnown());
  EXPECT_EQ(best.pose.position.x(), 2);
  EXPECT_EQ(best.depth, 0.25);
}

TEST(BestPose, TheLastFreePoseIsTheBest) {
  BestPose best;
  best.record(at(1), 0);
  best.record(at(2), 0.4 * kGapTolerance);
  EXPECT_EQ(best.pose.position.x(), 2);
  best.record(at(3), 2 * kGapTolerance);
  EXPECT_EQ(best.pose.position.x(), 2);
}

TEST(BestPose, CanBeReplacedByADeeperPose) {
  BestPose best;
  best.record(at(1), 0);
  best.set(at(2), 1);
  EXPECT_EQ(best.pose.position.x(), 2);
  EXPECT_EQ(best.depth, 1);
}

}  // namespace
}  // namespace spheretree::runtime
