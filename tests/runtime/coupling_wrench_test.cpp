// SPDX-License-Identifier: Apache-2.0
#include "step/coupling_wrench.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace spheretree::runtime {
namespace {

TEST(CouplingWrench, PullsTheHandTowardsTheGraphicTool) {
  const Configuration haptic{{0, 0, -1}, rotationOf({0.1, 0, 0})}, graphic{{0, 0, 0.5}, rotationOf({0, 0, 0})};
  const Wrench w = couplingWrench({2, 500}, haptic, graphic);
  EXPECT_LT((w.force - Eigen::Vector3d(0, 0, 3)).norm(), 1e-12);
  EXPECT_LT((w.torque - Eigen::Vector3d(-50, 0, 0)).norm(), 1e-9);
}

TEST(CouplingWrench, AWholeTurnIsNoTurn) {
  const Configuration a{{0, 0, 0}, rotationOf({0, 0, 3})}, b{{0, 0, 0}, rotationOf({0, 0, 3 - 2 * M_PI})};
  EXPECT_LT(couplingWrench({}, a, b).torque.norm(), 1e-9);
}

TEST(CouplingWrench, LimitsKeepTheDirection) {
  const WrenchLimits limits{8, {188, 188, 48}};
  const Wrench w{{30, -40, 0}, {100, 20, -96}};
  const Wrench l = limited(w, limits);
  EXPECT_NEAR(l.force.norm(), 8, 1e-12);
  EXPECT_LT(l.force.cross(w.force).norm(), 1e-9);
  EXPECT_NEAR(l.torque.z(), -48, 1e-12);
  EXPECT_LT(l.torque.cross(w.torque).norm(), 1e-9);
  const Wrench small{{1, 2, 3}, {4, 5, 6}};
  EXPECT_EQ(limited(small, limits).force, small.force);
  EXPECT_EQ(limited(small, limits).torque, small.torque);
}

TEST(CouplingWrench, WhatIsNotFiniteIsNotRendered) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(limited({{nan, 0, 0}, {0, 0, 1}}, {}).torque, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(limited({{1, 0, 0}, {0, INFINITY, 0}}, {}).force, Eigen::Vector3d(0, 0, 0));
}

}  // namespace
}  // namespace spheretree::runtime
