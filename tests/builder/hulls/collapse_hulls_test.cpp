// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/collapse_hulls.h"

#include <gtest/gtest.h>

#include "hulls/hull_change.h"
#include "support/hull_fit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

TEST(CollapseHulls, NoCollapseWithinTheToleranceIsLeft) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  HullComplex complex = rig.joined();
  const std::size_t balls = test::livingBalls(complex);
  collapseBalls(complex);
  EXPECT_LT(test::livingBalls(complex), balls);
  EXPECT_TRUE(test::isConsistent(complex));
  EXPECT_LE(test::worstSample(complex), complex.most());
  for (std::uint32_t v = 0; v < complex.balls().size(); ++v)
    for (const std::uint32_t w : complex.neighbours(v)) EXPECT_GT(collapseOf(complex, v, w, complex.most()).cost, complex.most());
}

TEST(CollapseHulls, TrialsLeaveNoMoreBallsAndNothingBare) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  HullComplex complex = rig.joined();
  collapseBalls(complex);
  complex.prune();
  complex.allowAll();
  const std::size_t balls = test::livingBalls(complex);
  tryCollapses(complex);
  EXPECT_LE(test::livingBalls(complex), balls);
  EXPECT_LE(test::worstSample(complex), complex.most());
}

}  // namespace
}  // namespace spheretree::builder
