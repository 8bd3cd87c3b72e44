// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/relax_balls.h"

#include <gtest/gtest.h>

#include "hulls/collapse_hulls.h"
#include "hulls/hull_change.h"
#include "support/hull_fit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

// A ball that was put beside the axis of a ring comes back, and what its hulls cost falls.
TEST(RelaxBalls, SharesTheCostOfHulls) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  HullComplex complex = rig.joined();
  collapseBalls(complex);
  std::uint32_t v = 0;
  while (complex.around(v).empty()) ++v;
  const double limit = 4 * complex.most();
  const Eigen::Vector3d c = complex.balls()[v].centre + Eigen::Vector3d(0, 0, 0.1);
  const HullChange change = moveOf(complex, v, {c, -rig.field.signedDistance(c)}, limit);
  ASSERT_LE(change.cost, limit);
  complex.apply(change);
  const double worst = test::worstSample(complex);
  ASSERT_GT(worst, complex.most());
  relaxBalls(complex, change.to, limit);
  EXPECT_LT(test::worstSample(complex), worst);
  EXPECT_TRUE(test::isConsistent(complex));
}

}  // namespace
}  // namespace spheretree::builder
