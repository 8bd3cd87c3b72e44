// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/inscribed_ball.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/shapes.h"
#include "support/smooth_shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// Below the middle of a plate of thickness 2, a ball at depth d has the radius min(d, 2 - d), so that it leaves a gap
// of at most g down to d = 1 + g / 2.
TEST(InscribedBall, IsAsDeepAsTheGapAllows) {
  const TriangleMesh plate = test::boxMesh({0, 0, 0}, {20, 20, 2});
  const DistanceField field(plate);
  for (const double gap : {0.01, 0.1, 0.5, 1.5}) {
    const Ball ball = ballBelow(field, {10, 10, 2}, Vector3d::UnitZ(), gap);
    EXPECT_NEAR(2 - ball.centre.z(), 1 + gap / 2, 0.01) << gap;
    EXPECT_LE(2 - ball.centre.z() - ball.radius, gap + 1e-12);
    EXPECT_NEAR(ball.radius, ball.centre.z(), 1e-12) << "it touches the other side";
  }
  EXPECT_EQ(ballBelow(field, {10, 10, 2}, Vector3d::UnitZ(), 3).radius, 0) << "the gap exceeds the thickness";
}

TEST(InscribedBall, IsCentredInAShaft) {
  const TriangleMesh shaft = test::cylinderMesh(1, 10, 64, 20);
  const DistanceField field(shaft);
  const Vector3d c(0.4, 0.1, 5);
  const Ball ball = centred(field, {c, -field.signedDistance(c)}, {1, 0, 5}, 0.2);
  EXPECT_LT(std::hypot(ball.centre.x(), ball.centre.y()), 0.01);
  EXPECT_GT(ball.radius, 0.99);
}

TEST(InscribedBall, AxesArePerpendicular) {
  const Vector3d unit = Vector3d(1, 2, 3).normalized();
  for (const Vector3d& other : {Vector3d(0, 1, 0), Vector3d(unit), Vector3d(-2, 0.5, 1)}) {
    const Eigen::Matrix3d axes = axesFrom(unit, other, 1e-6);
    EXPECT_LT((axes.transpose() * axes - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_GE(axes.col(1).dot(other), -1e-12) << "towards the other direction";
  }
}

}  // namespace
}  // namespace spheretree::builder
