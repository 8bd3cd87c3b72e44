// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/shrinking_balls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "geometry/surface_samples.h"
#include "support/dense_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// In a box the ball that touches a face at p is stopped by the face opposite, or by the nearest side face.
TEST(ShrinkingBalls, BoxGivesTheClosedForm) {
  const Vector3d low(0, 0, 0), high(8, 5, 2);
  const TriangleMesh box = test::boxMesh(low, high);
  const DistanceField field(box);
  int checked = 0;
  for (const SurfaceSample& s : sampleSurface(box, {2000, 0.5235987756, 2})) {
    if (s.feature) continue;
    double expected = 0.5 * std::abs((high - low).dot(s.normal));
    for (int axis = 0; axis < 3; ++axis)
      if (std::abs(s.normal[axis]) < 0.5) expected = std::min({expected, s.point[axis] - low[axis], high[axis] - s.point[axis]});
    if (expected < 1e-5) continue;
    EXPECT_NEAR(shrinkingBall(field, s.point, s.normal).radius, expected, 2e-3 * expected) << s.point.transpose();
    ++checked;
  }
  EXPECT_GT(checked, 1900);
}

TEST(ShrinkingBalls, ASheetGivesBallsOfHalfItsThickness) {
  for (const double thickness : {1e-1, 1e-3, 1e-5}) {
    const DistanceField field(test::boxMesh({0, 0, 0}, {10, 10, thickness}));
    EXPECT_NEAR(shrinkingBall(field, {4, 7, thickness}, {0, 0, 1}).radius, thickness / 2, 2e-3 * thickness);
  }
}

TEST(ShrinkingBalls, TouchTheSurfaceAtTheSampleAndAreInscribed) {
  const TriangleMesh torus = test::torusMesh(5, 2, 24, 12);
  const DistanceField field(torus);
  for (const SurfaceSample& s : sampleSurface(torus, {400, 0.5235987756, 2})) {
    if (s.feature) continue;
    const Ball ball = shrinkingBall(field, s.point, s.normal);
    if (ball.radius == 0) continue;
    EXPECT_NEAR(ball.radius, test::bruteDistance(torus, ball.centre), 1e-12);
    EXPECT_LT(field.signedDistance(ball.centre), 0);
    const Vector3d to = s.point - ball.centre;
    EXPECT_LE(ball.radius, to.norm() + 1e-12);
    EXPECT_GE(ball.radius, (1 - 1.001e-3) * to.norm());
    EXPECT_LT((to.normalized() - s.normal).norm(), 1e-9) << "the centre lies straight below the sample";
  }
}

TEST(ShrinkingBalls, SharpConvexEdgesAndCornersGiveNone) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(cube);
  EXPECT_EQ(shrinkingBall(field, {0, 0, 0.4}, Vector3d(-1, -1, 0).normalized()).radius, 0);
  EXPECT_EQ(shrinkingBall(field, {0, 0, 0}, Vector3d(-1, -1, -1).normalized()).radius, 0);
  EXPECT_NEAR(shrinkingBall(field, {0.5, 0.5, 0}, {0, 0, -1}).radius, 0.5, 1e-3);
}

// Below an edge of a cube, at the depth t straight in, the faces are t / sqrt(2) away; below a corner t / sqrt(3).
TEST(ShrinkingBalls, WithAStandOffThereIsOneBelowEdgesAndCorners) {
  const DistanceField field(test::boxMesh({0, 0, 0}, {1, 1, 1}));
  const double stand_off = 0.02;
  const Ball edge = shrinkingBall(field, {0, 0, 0.4}, Vector3d(-1, -1, 0).normalized(), stand_off);
  EXPECT_NEAR(edge.radius, stand_off / (std::sqrt(2.0) - 1), 1e-3 * edge.radius);
  const Ball corner = shrinkingBall(field, {0, 0, 0}, Vector3d(-1, -1, -1).normalized(), stand_off);
  EXPECT_NEAR(corner.radius, stand_off / (std::sqrt(3.0) - 1), 1e-3 * corner.radius);
  for (const Ball& ball : {edge, corner}) EXPECT_NEAR(ball.radius, -field.signedDistance(ball.centre), 1e-12);
}

}  // namespace
}  // namespace spheretree::builder
