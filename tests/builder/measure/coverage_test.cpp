// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr double kTolerance = 1e-5;

Coverage coverageOf(const TriangleMesh& mesh, const std::vector<Ball>& balls) {
  Progress progress;
  return measureCoverage(mesh, SphereUnion(balls), {.tolerance = kTolerance}, progress);
}

TEST(Coverage, BallInACubeLeavesTheCornersOpen) {
  const TriangleMesh cube = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  for (const double radius : {1.1, 1.3, 1.4}) {  // covers a disc of each face
    const Coverage coverage = coverageOf(cube, {{{0, 0, 0}, radius}});
    EXPECT_NEAR(coverage.uncovered_fraction, 1 - std::numbers::pi * (radius * radius - 1) / 4, 1e-3);
    EXPECT_NEAR(coverage.max_gap, std::sqrt(3.0) - radius, 1e-12);
    EXPECT_GE(coverage.max_gap_bound, std::sqrt(3.0) - radius - 1e-12);
    EXPECT_LE(coverage.max_gap_bound, coverage.max_gap + 0.5 * kTolerance);
    EXPECT_NEAR(coverage.worst_point.norm(), std::sqrt(3.0), 1e-12);
  }
  const Coverage whole = coverageOf(cube, {{{0, 0, 0}, 1.7321}});
  EXPECT_EQ(whole.uncovered_fraction, 0);
  EXPECT_EQ(whole.max_gap, 0);
  EXPECT_LE(whole.max_gap_bound, 1.5 * kTolerance);
}

// A gap far smaller than the spacing of the samples, in the middle of a face, where no mesh corner is.
TEST(Coverage, FindsATinyGap) {
  const TriangleMesh slab = test::boxMesh({-1, -1, -1}, {1, 1, 0});
  const double hole = 1e-3;
  std::vector<Ball> balls{{{0.31, 0.17, -10}, std::sqrt(100 + 0)}, {{0, 0, -8}, 7}};
  for (int k = 0; k < 6; ++k) {  // a ring of balls about (0.31, 0.17), and balls over the rest of the slab
    const double angle = 2 * std::numbers::pi * k / 6;
    balls.push_back({{0.31 + 2 * std::cos(angle), 0.17 + 2 * std::sin(angle), 0}, 2 - hole});
  }
  balls[0].radius -= 5e-5;  // its top stays below the face by this much
  const Coverage coverage = coverageOf(slab, balls);
  const double distance_to_ring = hole, gap = std::min(distance_to_ring, 5e-5);
  EXPECT_NEAR(coverage.max_gap, gap, 2 * kTolerance);
  EXPECT_LT(coverage.uncovered_fraction, 1e-3);
}

TEST(Coverage, GapIsNeverAboveItsBoundNorBelowASample) {
  test::Random random(1);
  const TriangleMesh mesh = test::torusMesh(2, 0.8, 20, 9);
  for (int round = 0; round < 10; ++round) {
    std::vector<Ball> balls;
    for (int k = 0; k < 40; ++k) {
      const Vector3d centre = random.inBox({-3, -3, -1}, {3, 3, 1});
      balls.push_back({centre, random.between(0.3, 1)});
    }
    const Coverage coverage = coverageOf(mesh, balls);
    EXPECT_LE(coverage.max_gap, coverage.max_gap_bound);
    EXPECT_LE(coverage.max_gap_bound, coverage.max_gap + 0.5 * kTolerance);
    for (const SurfacePoint& sample : spreadOverSurface(mesh, 20000, 7)) {
      double gap = std::numeric_limits<double>::infinity();
      for (const Ball& ball : balls) gap = std::min(gap, (sample.point - ball.centre).norm() - ball.radius);
      EXPECT_LE(gap, coverage.max_gap_bound);
    }
  }
}

TEST(Coverage, GrowingARadiusNeverUncovers) {
  test::Random random(2);
  const TriangleMesh mesh = test::sphereMesh(1, 3);
  std::vector<Ball> balls;
  for (int k = 0; k < 30; ++k) balls.push_back({0.7 * random.direction(), 0.4});
  Coverage before = coverageOf(mesh, balls);
  for (int round = 0; round < 10; ++round) {
    balls[random.below(balls.size())].radius *= 1.2;
    const Coverage after = coverageOf(mesh, balls);
    EXPECT_LE(after.uncovered_fraction, before.uncovered_fraction);
    EXPECT_LE(after.max_gap, before.max_gap + 0.5 * kTolerance);
    before = after;
  }
  EXPECT_LT(before.uncovered_fraction, 1);
}

TEST(Coverage, SurfacePointsLieOnTheirTrianglesAndFollowTheArea) {
  const TriangleMesh box = test::boxMesh({0, 0, 0}, {1, 2, 5});
  const std::size_t count = 10000;
  const std::vector<SurfacePoint> points = spreadOverSurface(box, count, 3);
  ASSERT_EQ(points.size(), count);
  std::vector<double> share(12, 0);
  for (const SurfacePoint& point : points) {
    share[point.triangle] += 1.0 / static_cast<double>(count);
    EXPECT_NEAR(test::boxDistance({0, 0, 0}, {1, 2, 5}, point.point), 0, 1e-15);
  }
  for (std::size_t t = 0; t < 12; ++t) {
    const double area = 0.5 * (box.corner(t, 1) - box.corner(t, 0)).cross(box.corner(t, 2) - box.corner(t, 0)).norm();
    EXPECT_NEAR(share[t], area / 34, 1.5 / static_cast<double>(count));
  }
  EXPECT_NE(spreadOverSurface(box, 1, 4)[0].point, spreadOverSurface(box, 1, 5)[0].point);
}

TEST(Coverage, NoBallsCoverNothing) {
  const Coverage coverage = coverageOf(test::boxMesh({0, 0, 0}, {1, 1, 1}), {});
  EXPECT_EQ(coverage.uncovered_fraction, 1);
  EXPECT_TRUE(std::isinf(coverage.max_gap));
}

TEST(Coverage, RefusesWhatItCannotMeasure) {
  Progress progress;
  const SphereUnion balls(std::vector<Ball>{{{0, 0, 0}, 1}});
  TriangleMesh flat = test::boxMesh({0, 0, 0}, {0, 0, 0});
  EXPECT_THROW(measureCoverage(flat, balls, {.tolerance = 1}, progress), std::invalid_argument);
  EXPECT_THROW(measureCoverage(test::boxMesh({0, 0, 0}, {1, 1, 1}), balls, {.tolerance = 0}, progress), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::builder
