// SPDX-License-Identifier: Apache-2.0
#include "piece/rest_rule.h"

#include <gtest/gtest.h>

namespace spheretree::runtime {
namespace {

TEST(RestRule, AStepBelowRoundingCountsOnlyWhileStepsShrink) {
  const Vector6 along = Vector6::Unit(1);
  SecantStep last;
  EXPECT_TRUE(RestRule::isNegligible(0.9 * kConverged * along, last));
  EXPECT_FALSE(RestRule::isNegligible(0.5 * kRounding * along, last)) << "there is no last piece";
  last.note(kRounding * along, kRounding * along);
  EXPECT_FALSE(RestRule::isNegligible(0.5 * kRounding * along, last)) << "half as long: it shrinks";
  EXPECT_TRUE(RestRule::isNegligible(0.9 * kRounding * along, last));
  EXPECT_FALSE(RestRule::isNegligible(1.1 * kRounding * along, last));
}

TEST(RestRule, TheSameForcesHoldTheToolAfterAWholePiece) {
  RestRule rule;
  EXPECT_FALSE(rule.mayHold());
  const Vector6 friction = 3 * Vector6::Unit(0);  // what the normal forces leave is held by friction
  rule.noteForces(friction);
  rule.notePiece(true);
  EXPECT_TRUE(rule.mayHold());
  EXPECT_TRUE(rule.holds(friction + 0.5 * kConverged * Vector6::Unit(4)));
  EXPECT_FALSE(rule.holds(friction + 2 * kConverged * Vector6::Unit(4)));
  rule.notePiece(false);
  EXPECT_FALSE(rule.mayHold());
}

// The distances to the haptic pose after each piece of a tool that approaches by `step` in each.
int piecesUntilStalled(double step, int limit) {
  RestRule rule;
  double left_over = 1;
  for (int piece = 1; piece <= limit; ++piece) {
    left_over -= step;
    if (rule.isCheckDue() && rule.hasStalled(left_over)) return piece;
  }
  return limit + 1;
}

TEST(RestRule, AToolThatComesNoNearerStallsAfterTwoChecks) {
  EXPECT_EQ(piecesUntilStalled(0, 100), 2 * kPatience);
  EXPECT_EQ(piecesUntilStalled(-0.1, 100), 2 * kPatience) << "it goes away";
  EXPECT_EQ(piecesUntilStalled(0.9 * kProgress / kPatience, 100), 2 * kPatience);
  EXPECT_EQ(piecesUntilStalled(1.1 * kProgress / kPatience, 100), 101);
}

}  // namespace
}  // namespace spheretree::runtime
