// SPDX-License-Identifier: Apache-2.0
#include "piece/secant_step.h"

#include <gtest/gtest.h>

#include "support/random.h"

namespace spheretree::runtime {
namespace {

Vector6 someVector(test::Random& random) {
  Vector6 v;
  for (double& x : v) x = random.between(-1, 1);
  return v;
}

TEST(SecantStep, SaysNothingWithoutALastPiece) {
  test::Random random(1);
  const Vector6 plain = someVector(random);
  Vector6 further;
  SecantStep secant;
  EXPECT_EQ(secant.damping(-plain), 1);
  EXPECT_FALSE(secant.extrapolate(plain, further));
  EXPECT_FALSE(secant.isStagnant(plain));
  secant.note(plain, plain);
  secant.forget();
  EXPECT_EQ(secant.damping(-plain), 1);
  EXPECT_FALSE(secant.extrapolate(plain, further));
  EXPECT_FALSE(secant.isStagnant(plain));
}

// Plain steps p, q p, q^2 p, ...: the tool is at x after the first one, and the series ends at p / (1 - q).
TEST(SecantStep, FindsTheSumOfAGeometricSeries) {
  test::Random random(2);
  for (const double factor : {0.1, 0.5, 0.9}) {
    const Vector6 first = someVector(random), plain = factor * first;
    SecantStep secant;
    secant.note(first, first);
    EXPECT_EQ(secant.damping(plain), 1);
    Vector6 further;
    ASSERT_TRUE(secant.extrapolate(plain, further));
    EXPECT_LT((first + plain + further - first / (1 - factor)).norm(), 1e-12 / (1 - factor)) << factor;
  }
}

// The formula of Anderson mixing with a memory of one, from the paper: the combination of the last two iterates that
// has the smallest residual, and the same combination of their images.
TEST(SecantStep, IsAndersonMixingOfTwoIterates) {
  test::Random random(3);
  int compared = 0;
  for (int n = 0; n < 100; ++n) {
    const Vector6 last_plain = someVector(random), way = someVector(random).cwiseAbs().cwiseProduct(last_plain);
    const Vector6 plain = 0.5 * last_plain + 0.1 * someVector(random), change = plain - last_plain;
    if (!(-change.dot(way) > 0.1 * way.squaredNorm()) || !(plain.dot(last_plain) > 0.2 * plain.norm() * last_plain.norm())) continue;
    SecantStep secant;
    secant.note(last_plain, way);
    Vector6 further;
    ASSERT_TRUE(secant.extrapolate(plain, further));
    // The last iterate is at -way, the present one at 0; their images are at -way + last_plain and at plain.
    const double share = plain.dot(change) / change.squaredNorm();
    const Vector6 residual = (1 - share) * plain + share * last_plain, image = (1 - share) * plain + share * (last_plain - way);
    EXPECT_NEAR(residual.dot(change), 0, 1e-12);  // smallest
    EXPECT_LT((plain + further - image).norm(), 1e-12);
    ++compared;
  }
  EXPECT_GT(compared, 30);
}

TEST(SecantStep, DoesNotExtrapolateOverACorner) {
  Vector6 last = Vector6::Unit(0), across = Vector6::Unit(1), further;
  SecantStep secant;
  secant.note(last, last);
  EXPECT_FALSE(secant.extrapolate(across, further));
  EXPECT_FALSE(secant.extrapolate(-0.5 * last, further));
}

TEST(SecantStep, GoesFourTimesAsFarWhereStepsGrow) {
  const Vector6 last = Vector6::Unit(2), plain = 1.5 * last;
  SecantStep secant;
  secant.note(last, last);
  Vector6 further;
  ASSERT_TRUE(secant.extrapolate(plain, further));
  EXPECT_EQ(plain + further, 4 * plain);
}

// The plain step changes from 1 to -q along the way, so that its zero is q / (1 + q) of the way back.
TEST(SecantStep, ADampedStepEndsAtTheMinimum) {
  test::Random random(4);
  for (const double overshoot : {0.2, 1.0, 3.0}) {
    const Vector6 way = someVector(random), plain = -overshoot * way;
    SecantStep secant;
    secant.note(way, way);
    EXPECT_NEAR(secant.damping(plain), 1 / (1 + overshoot), 1e-12);
    EXPECT_LE(secant.damping(plain), 1);
  }
}

TEST(SecantStep, StepsThatShrinkAreNotStagnant) {
  test::Random random(5);
  const Vector6 way = someVector(random);
  SecantStep secant;
  secant.note(way, way);
  EXPECT_FALSE(secant.isStagnant(0.6 * way));
  EXPECT_TRUE(secant.isStagnant(0.8 * way));
}

}  // namespace
}  // namespace spheretree::runtime
