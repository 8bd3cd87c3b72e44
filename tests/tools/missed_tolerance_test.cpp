// SPDX-License-Identifier: Apache-2.0
#include "pipeline/missed_tolerance.h"

#include <gtest/gtest.h>

#include <string>

namespace spheretree::pipeline {
namespace {

TEST(MissedTolerance, StatesTheNeededLeaves) {
  EXPECT_EQ(missedTolerance(0.2, 4.0962, 512),
            "the tolerance of 0.2 mm is not met; the best result was written: 512 leaves with an overhang of 4.1 mm. The tolerance needs "
            "about 11000 leaves: 6 levels with 8 children for each node.");
  EXPECT_EQ(missedTolerance(0.5, 1, 4),
            "the tolerance of 0.5 mm is not met; the best result was written: 4 leaves with an overhang of 1 mm. The tolerance needs "
            "about 8 leaves: 2 levels with 8 children for each node.");
  EXPECT_NE(missedTolerance(0.1, 0.101, 505).find(" leaves: 5 levels"), std::string::npos) << "512 had room for them";
  // 512 leaves are not said to suffice if as many do not.
  EXPECT_NE(missedTolerance(0.2, 0.2037, 502).find("about 520 leaves: 5 levels"), std::string::npos);
}

TEST(MissedTolerance, StatesTheReachOfTheLargestTree) {
  EXPECT_EQ(missedTolerance(1e-6, 2, 512),
            "the tolerance of 1e-06 mm is not met; the best result was written: 512 leaves with an overhang of 2 mm. The largest "
            "tree, 32768 leaves on 6 levels, reaches about 0.031 mm.");
}

}  // namespace
}  // namespace spheretree::pipeline
