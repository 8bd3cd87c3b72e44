// SPDX-License-Identifier: Apache-2.0
#include "pipeline/missed_tolerance.h"

#include <gtest/gtest.h>

namespace spheretree::pipeline {
namespace {

TEST(MissedTolerance, SaysWhatItWouldTake) {
  EXPECT_EQ(missedTolerance(0.2, 4.0962, 512),
            "the tolerance of 0.2 mm is not met; the best result was written, whose 512 leaves keep 4.1 mm. The tolerance takes about "
            "11000 leaves: 6 levels with 8 children a node.");
  EXPECT_EQ(missedTolerance(0.5, 1, 4),
            "the tolerance of 0.5 mm is not met; the best result was written, whose 4 leaves keep 1 mm. The tolerance takes about 8 "
            "leaves: 2 levels with 8 children a node.");
}

TEST(MissedTolerance, SaysThatNoTreeHasSoManyLeaves) {
  EXPECT_EQ(missedTolerance(1e-6, 2, 512),
            "the tolerance of 1e-06 mm is not met; the best result was written, whose 512 leaves keep 2 mm. The most leaves of a tree, "
            "32768 on 6 levels, keep about 0.031 mm.");
}

}  // namespace
}  // namespace spheretree::pipeline
