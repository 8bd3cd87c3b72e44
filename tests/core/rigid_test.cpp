// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/rigid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "support/shape_trees.h"

namespace spheretree {
namespace {

using test::Random;

TEST(Rigid, ExpAndLogAreInverse) {
  Random random(1);
  for (int n = 0; n < 20000; ++n) {
    // All sizes from 1e-12 rad to just below half a turn.
    const double angle = std::min(std::pow(10, random.between(-12, 0.5)), M_PI - 1e-6);
    const Eigen::Vector3d v = angle * (test::randomRotation(random) * Eigen::Vector3d::UnitX());
    const Quaternion q = rotationOf(v);
    EXPECT_NEAR(q.norm(), 1, 1e-14);
    EXPECT_LT((rotationVector(q) - v).norm(), 1e-9 * angle);
    EXPECT_EQ(rotationVector(q), rotationVector(Quaternion(-q.w(), -q.x(), -q.y(), -q.z())));
  }
  EXPECT_EQ(rotationVector(Quaternion(1, 0, 0, 0)), Eigen::Vector3d(0, 0, 0));
  EXPECT_NEAR(rotationVector(Quaternion(0, 0, 0, 1)).norm(), M_PI, 1e-15);  // half a turn has a length and no preferred sign
}

TEST(Rigid, KnownRotation) {
  const Quaternion quarter = rotationOf({0, 0, M_PI / 2});  // counter-clockwise about z
  EXPECT_LT((quarter * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-15);
}

TEST(Rigid, AStepLeadsWhereItWasMeasured) {
  Random random(2);
  for (int n = 0; n < 2000; ++n) {
    const Configuration a{test::randomPoint(random, 100), test::randomRotation(random)},
        b{test::randomPoint(random, 100), test::randomRotation(random)};
    const Configuration c = moved(a, displacementBetween(a, b));
    EXPECT_LT((c.position - b.position).norm(), 1e-12);
    EXPECT_LT(rotationVector(c.orientation * b.orientation.conjugate()).norm(), 1e-9);
    EXPECT_LE(displacementBetween(a, b).rotation.norm(), M_PI + 1e-12);
  }
}

TEST(Rigid, AWrenchTakenAboutAnotherPoint) {
  // 1 N at a tip 100 mm from the handle is 100 N mm there.
  const Wrench at_tip{{0, 0, 1}, {0, 0, 0}};
  const Wrench at_handle = wrenchAbout(at_tip, {100, 0, 0}, {0, 0, 0});
  EXPECT_EQ(at_handle.force, at_tip.force);
  EXPECT_EQ(at_handle.torque, Eigen::Vector3d(0, -100, 0));
  EXPECT_EQ(wrenchAbout(at_handle, {0, 0, 0}, {100, 0, 0}).torque, at_tip.torque);
}

TEST(Rigid, KnowsWhatIsNotAPose) {
  EXPECT_TRUE(isFinite({}));
  EXPECT_FALSE(isFinite({{std::numeric_limits<double>::quiet_NaN(), 0, 0}, Quaternion(1, 0, 0, 0)}));
  EXPECT_FALSE(isFinite({{0, 0, 0}, Quaternion(0, 0, 0, 0)}));
  EXPECT_FALSE(isFinite({{0, 0, 0}, Quaternion(1, std::numeric_limits<double>::infinity(), 0, 0)}));
}

}  // namespace
}  // namespace spheretree
