// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/relax_cover.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <random>

#include "base/random.h"
#include "cover/farthest_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr double kNoise = 0.02;

TriangleMesh noisyTorus() {
  TriangleMesh mesh = test::torusMesh(5, 2, 96, 48);
  std::mt19937_64 random(1);
  for (Vector3d& p : mesh.positions)
    for (int k = 0; k < 3; ++k) p[k] += kNoise * (2 * randomUnit(random) - 1);
  return mesh;
}

// The smallest stand-off with which the balls about these centres cover the points.
double standOff(const DistanceField& field, std::span<const Vector3d> points, std::span<const Ball> balls) {
  std::vector<double> clearance;
  for (const Ball& b : balls) clearance.push_back(-field.signedDistance(b.centre));
  double largest = 0;
  for (const Vector3d& p : points) {
    double smallest = kInfinity;
    for (std::size_t b = 0; b < balls.size(); ++b) smallest = std::min(smallest, (p - balls[b].centre).norm() - clearance[b]);
    largest = std::max(largest, smallest);
  }
  return largest;
}

std::vector<Ball> coverOf(const TriangleMesh& mesh) {
  const DistanceField field(mesh);
  std::vector<Vector3d> middles;  // at no edge, where no inscribed ball touches
  for (const auto& [a, b, c] : mesh.triangles) middles.emplace_back((mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3);
  std::vector<Ball> balls = farthestPointBalls(field, middles, 40);
  const double h = standOff(field, mesh.positions, balls);
  for (Ball& b : balls) b.radius += h;
  return balls;
}

TEST(RelaxCover, PointsAreCoveredWithASmallerStandOff) {
  const TriangleMesh smooth = test::torusMesh(5, 2, 96, 48), noisy = noisyTorus();
  const DistanceField field(noisy);
  std::vector<Ball> balls = coverOf(smooth);
  const double before = standOff(field, noisy.positions, balls);
  Progress progress;
  relaxCover(field, noisy.positions, 2 * kNoise, balls, progress);
  const double after = standOff(field, noisy.positions, balls);
  ASSERT_EQ(balls.size(), 40u);
  EXPECT_LT(after, 0.95 * before);
  for (const Ball& b : balls) EXPECT_LE(b.radius + field.signedDistance(b.centre), after * (1 + 1e-9));
  for (const Vector3d& p : noisy.positions)
    EXPECT_TRUE(std::ranges::any_of(balls, [&](const Ball& b) { return (p - b.centre).norm() <= b.radius * (1 + 1e-12); }));
}

TEST(RelaxCover, WhatHardlyMovedStaysAsItIs) {
  const TriangleMesh mesh = test::torusMesh(5, 2, 96, 48);
  std::vector<Ball> balls = coverOf(mesh);
  const std::vector<Ball> before = balls;
  Progress progress;
  relaxCover(DistanceField(mesh), mesh.positions, 1e-6, balls, progress);
  for (std::size_t b = 0; b < balls.size(); ++b) {
    EXPECT_EQ(balls[b].centre, before[b].centre);
    EXPECT_EQ(balls[b].radius, before[b].radius);
  }
}

TEST(RelaxCover, TheSameForAnyNumberOfThreads) {
  const TriangleMesh noisy = noisyTorus();
  const DistanceField field(noisy);
  std::vector<std::vector<Ball>> found;
  for (const std::size_t threads : {1u, 4u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    found.push_back(coverOf(test::torusMesh(5, 2, 96, 48)));
    Progress progress;
    relaxCover(field, noisy.positions, 2 * kNoise, found.back(), progress);
  }
  for (std::size_t b = 0; b < found[0].size(); ++b) {
    EXPECT_EQ(found[0][b].centre, found[1][b].centre);
    EXPECT_EQ(found[0][b].radius, found[1][b].radius);
  }
}

}  // namespace
}  // namespace spheretree::builder
