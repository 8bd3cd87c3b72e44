// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/gap_sampler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "support/dense_points.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr double kRise = 0.3, kTolerance = 0.05, kSpacing = 0.05;

std::vector<Ball> inscribedBalls(const DistanceField& field, std::size_t count) {
  test::Random random(7);
  std::vector<Ball> balls;
  while (balls.size() < count) {
    const Vector3d c = random.inBox(field.box().min(), field.box().max());
    if (const double clearance = -field.signedDistance(c); clearance > 0) balls.push_back({c, clearance});
  }
  return balls;
}

double gapAt(const Vector3d& p, std::span<const Ball> balls) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const Ball& b : balls) smallest = std::min(smallest, (p - b.centre).norm() - b.radius);
  return smallest;
}

struct GapSamplerOnATorus : testing::Test {
  const TriangleMesh mesh = test::torusMesh(5, 2, 48, 24);
  const DistanceField field{mesh};
  std::vector<Ball> balls = inscribedBalls(field, 60);
  GapSampler sampler{mesh, field, balls.size(), kSpacing};
  Progress progress;
  std::vector<Vector3d> findEverywhere(double rise, double tolerance) { return sampler.find(balls, rise, tolerance, nullptr, progress); }
};

TEST_F(GapSamplerOnATorus, FindsPointsOfTheMeshThatNoBallReaches) {
  const std::vector<Vector3d> found = findEverywhere(kRise, kTolerance);
  ASSERT_FALSE(found.empty());
  for (const Vector3d& p : found) {
    EXPECT_LT(test::bruteDistance(mesh, p), 1e-12);
    EXPECT_GT(gapAt(p, balls), (1 + kTolerance) * kRise * (1 - 1e-9));
  }
}

TEST_F(GapSamplerOnATorus, FindsNothingOnceTheBallsReachTheDeepestHole) {
  const double deepest = test::largestGap(test::densePoints(mesh, 30, 3), balls);
  for (const double tolerance : {0.0, kTolerance}) {
    EXPECT_FALSE(findEverywhere(0.99 * deepest / (1 + tolerance), tolerance).empty());
    EXPECT_TRUE(findEverywhere(1.01 * deepest / (1 + tolerance), tolerance).empty());
  }
}

TEST_F(GapSamplerOnATorus, AfterMovesLooksOnlyWhereBallsMovedAndMissesNothing) {
  GapSampler fresh(mesh, field, balls.size(), kSpacing);
  // The balls are large enough that few places are open: otherwise every triangle would have to be examined.
  const double rise = 0.9 * test::largestGap(test::densePoints(mesh, 10, 3), balls);
  findEverywhere(rise, kTolerance);
  EXPECT_EQ(sampler.lookedAt(), sampler.triangles());
  for (const std::uint32_t moved : {3u, 30u, 59u}) {
    const std::vector<Ball> left{balls[moved]};
    balls[moved] = balls[(moved + 1) % balls.size()];
    const std::vector<Vector3d> found = sampler.find(balls, rise, kTolerance, &left, progress);
    EXPECT_EQ(found, fresh.find(balls, rise, kTolerance, nullptr, progress));
    EXPECT_LT(sampler.lookedAt(), sampler.triangles());
  }
}

}  // namespace
}  // namespace spheretree::builder
