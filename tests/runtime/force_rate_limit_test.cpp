// SPDX-License-Identifier: Apache-2.0
#include "piece/force_rate_limit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"

namespace spheretree::runtime {
namespace {

constexpr double kAngleLength = 10;  // [mm]

Coupling pull() {
  Coupling k;
  k.translation = 2;
  k.rotation = 2 * kAngleLength * kAngleLength;
  return k;
}

Vector6 vectorIn(test::Random& random, double size) {
  Vector6 v;
  for (double& x : v) x = random.between(-size, size);
  return v;
}

TEST(ForceRateLimit, ARestingHandAllowsWhatIsNotFelt) {
  const Vector6 zero = Vector6::Zero(), right = Vector6::Unit(0), about = Vector6::Unit(3);
  const ForceRateLimit limit(pull(), kAngleLength, zero, zero, zero);
  EXPECT_NEAR(pull().translation * limit.shareWithin(zero, right, 1), kForceStep, 1e-12);  // [N]
  // 2.5 N mm are 0.0125 rad here; all six components may change by no more than the translation.
  EXPECT_NEAR(limit.shareWithin(zero, about, 1), kForceStep / pull().translation, 1e-12);
}

TEST(ForceRateLimit, ALargeForceMayChangeByAShareOfIt) {
  const Vector6 zero = Vector6::Zero(), before = 4 * Vector6::Unit(1);
  const ForceRateLimit limit(pull(), kAngleLength, before, zero, before);
  EXPECT_NEAR(limit.shareWithin(before, Vector6::Unit(0), 1), 4 * kForceStepPart, 1e-12);
}

// The tool rests and the hand moves: the stretch changes by as much as the hand has moved. That is allowed, and so is a
// tool that follows the hand, wholly or in part.
TEST(ForceRateLimit, DoesNotHoldBackFromFollowingTheHand) {
  test::Random random(1);
  for (int n = 0; n < 1000; ++n) {
    const Vector6 before = vectorIn(random, 1), hand = vectorIn(random, 1), stretch = before + hand;
    const ForceRateLimit limit(pull(), kAngleLength, before, hand, stretch);
    EXPECT_EQ(limit.shareWithin(stretch, hand, 1), 1);
    EXPECT_EQ(limit.shareWithin(stretch, hand, 0.3), 0.3);
    EXPECT_EQ(limit.shareWithin(stretch, Vector6::Zero(), 1), 1);
  }
}

TEST(ForceRateLimit, TheShareIsTheLargestWithinTheLimit) {
  test::Random random(2);
  int shortened = 0;
  for (int n = 0; n < 1000; ++n) {
    const Vector6 before = vectorIn(random, 1), hand = vectorIn(random, 0.02), stretch = before + hand, way = vectorIn(random, 1);
    const ForceRateLimit limit(pull(), kAngleLength, before, hand, stretch);
    const double share = limit.shareWithin(stretch, way, 1);
    ASSERT_GE(share, 0);
    ASSERT_LE(share, 1);
    if (share == 1) continue;
    ++shortened;
    // After the piece the whole way to the limit is used up; a little less leaves some of it.
    EXPECT_LT(limit.shareWithin(stretch - share * way, way, 1), 1e-6);
    EXPECT_GT(limit.shareWithin(stretch - 0.9 * share * way, way, 1), 0.05 * share);
  }
  EXPECT_GT(shortened, 900);
}

TEST(ForceRateLimit, AMovingBodyAllowsItsMotion) {
  const Vector6 zero = Vector6::Zero(), right = Vector6::Unit(0);
  ForceRateLimit limit(pull(), kAngleLength, zero, zero, zero);
  const double alone = limit.shareWithin(zero, right, 1);
  limit.allow(0.5 * right);
  EXPECT_NEAR(limit.shareWithin(zero, right, 1), alone + 0.5, 1e-12);
  limit.allow(-0.25 * right);
  EXPECT_NEAR(limit.shareWithin(zero, right, 1), alone + 0.75, 1e-12);
}

TEST(ForceRateLimit, ALiftedLimitAllowsEverything) {
  const Vector6 zero = Vector6::Zero();
  ForceRateLimit limit(pull(), kAngleLength, zero, zero, zero);
  limit.lift();
  EXPECT_EQ(limit.shareWithin(zero, 1e6 * Vector6::Ones(), 1), 1);
}

}  // namespace
}  // namespace spheretree::runtime
