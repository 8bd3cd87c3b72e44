// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/cover_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "measure/overhang.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

CoverLimits limits(const TriangleMesh& mesh, std::size_t balls) {
  Progress progress;
  return coverLimits(mesh, DistanceField(mesh), balls, {}, progress);
}

// Under the middle of every n-th triangle of a mesh of uniform thickness; flat faces reduce the radius slightly.
void expectInnerRadius(const TriangleMesh& mesh, std::uint32_t n, double smallest, double largest) {
  const DistanceField field(mesh);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); t += n) {
    const Vector3d middle = (mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3;
    const double radius = largestInnerBall(field, middle, t, 0.5235987756).radius;
    EXPECT_GE(radius, smallest) << "triangle " << t;
    EXPECT_LE(radius, largest) << "triangle " << t;
  }
}

TEST(CoverLimits, InnerBallOfASphereIsTheSphere) { expectInnerRadius(test::sphereMesh(2, 4), 37, 1.8, 2); }

// Thinner than a thousandth of its size, and bent: large balls touch distant parts of it.
TEST(CoverLimits, InnerBallOfAThinRingIsAsThickAsTheRing) { expectInnerRadius(test::torusMesh(50, 0.02, 400, 16), 371, 0.016, 0.0201); }

TEST(CoverLimits, InnerBallOfASlabTouchesBothFaces) {
  const TriangleMesh slab = test::boxMesh({-10, -10, 0}, {10, 10, 1});
  const DistanceField field(slab);
  const Ball ball = largestInnerBall(field, {3, -2, 0}, 0, 0.5235987756);
  EXPECT_NEAR(ball.radius, 0.5, 1e-3);
  EXPECT_NEAR((ball.centre - Vector3d(3, -2, 0.5)).norm(), 0, 1e-3);
  // Next to a convex edge the ball touches the face beyond it.
  EXPECT_NEAR(largestInnerBall(field, {9.8, 0, 0}, 0, 0.5235987756).radius, 0.2, 1e-3);
}

// In a wide slab r = 1/2 nearly everywhere, so that n 2 pi h = 1.2092 A / (1 + h).
TEST(CoverLimits, WideSlabGivesTheClosedForm) {
  const TriangleMesh slab = test::boxMesh({0, 0, 0}, {300, 300, 1});
  const double area = 2 * 300 * 300 + 4 * 300;
  for (const double balls : {20000.0, 60000.0}) {
    const double k = 1.2091995761561452 * area / (2 * std::numbers::pi * balls);
    EXPECT_NEAR(limits(slab, static_cast<std::size_t>(balls)).h_fin, 0.5 * (std::sqrt(1 + 4 * k) - 1), 0.01 * k);
  }
}

// The hexagonal lattice of balls about the middle plane covers a slab with the smallest overhang: h_fin equals it, and
// h_low is below it.
TEST(CoverLimits, LatticeOverASlabLiesAtTheLimits) {
  const double side = 60, spacing = 1.5;
  const TriangleMesh slab = test::boxMesh({0, 0, -0.5}, {side, side, 0.5});
  // Every point of the face is within spacing / sqrt 3 of a lattice point.
  const double overhang = std::hypot(0.5, spacing / std::sqrt(3.0)) - 0.5;
  const double balls = side * side / (spacing * spacing * std::sqrt(3.0) / 2);
  const CoverLimits limit = limits(slab, static_cast<std::size_t>(balls));
  EXPECT_NEAR(limit.h_fin, overhang, 0.08 * overhang);  // the rim needs additional balls
  EXPECT_LE(limit.h_low, 1.05 * overhang);
  EXPECT_GE(limit.h_low, 0.7 * overhang);
  EXPECT_TRUE(limit.h_low_in_range);
}

TEST(CoverLimits, FallWithMoreBalls) {
  const TriangleMesh torus = test::torusMesh(2, 0.7, 40, 16);
  CoverLimits before = limits(torus, 8);
  for (const std::size_t balls : {16, 64, 256, 1024, 4096}) {
    const CoverLimits now = limits(torus, balls);
    EXPECT_LT(now.h_fin, before.h_fin);
    EXPECT_LT(now.h_low, before.h_low);
    before = now;
  }
}

TEST(CoverLimits, RefusesSettingsOutOfRange) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(cube);
  Progress progress;
  EXPECT_THROW(coverLimits(cube, field, 0, {}, progress), std::invalid_argument);
  EXPECT_THROW(coverLimits(cube, field, 8, {.samples = 10, .candidates = 11}, progress), std::invalid_argument);
  progress.cancel();
  EXPECT_THROW(coverLimits(cube, field, 8, {}, progress), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
