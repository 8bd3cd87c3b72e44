// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/overhang.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

Overhang overhangOf(const TriangleMesh& mesh, const std::vector<Ball>& balls) {
  Progress progress;
  return measureOverhang(DistanceField(mesh), SphereUnion(balls), {}, progress);
}

const TriangleMesh kUnitCube = test::boxMesh({-1, -1, -1}, {1, 1, 1});
const double kCubeDiagonal = std::sqrt(12.0);

TEST(Overhang, BallAroundACubeReachesFarthestOverTheFaces) {
  for (const double radius : {1.2, std::sqrt(2.0), 1.8, 3.0}) {
    const Overhang overhang = overhangOf(kUnitCube, {{{0, 0, 0}, radius}});
    EXPECT_NEAR(overhang.max, radius - 1, 1e-9);
    EXPECT_GE(overhang.bound, radius - 1 - 1e-15);
    EXPECT_NEAR(overhang.bound, radius - 1, 1e-4 * (radius - 1));
    EXPECT_NEAR(overhang.worst_point.norm(), radius, 1e-12);
    EXPECT_EQ(overhang.worst_ball, 0u);
  }
}

TEST(Overhang, PercentileAndMeanAreThoseOfRandomPoints) {
  const double radius = 1.8;  // larger than the corners: everything is outside
  const Overhang overhang = overhangOf(kUnitCube, {{{0, 0, 0}, radius}});
  test::Random random(1);
  std::vector<double> values;
  double sum = 0;
  for (int k = 0; k < 200000; ++k) {
    values.push_back(test::boxDistance({-1, -1, -1}, {1, 1, 1}, radius * random.direction()));
    sum += values.back();
  }
  std::sort(values.begin(), values.end());
  EXPECT_NEAR(overhang.mean, sum / 200000, 2e-3);
  EXPECT_NEAR(overhang.p99, values[198000], 2e-3);
  EXPECT_NEAR(overhang.outside_area, 4 * std::numbers::pi * radius * radius, 1e-6);
}

TEST(Overhang, ConcentricBallOfASphereMeshReachesOverTheFlattestFace) {
  const TriangleMesh mesh = test::sphereMesh(2, 3);
  const DistanceField field(mesh);
  double nearest_face = 2;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) nearest_face = std::min(nearest_face, field.normal(t).dot(mesh.corner(t, 0)));
  const Overhang overhang = overhangOf(mesh, {{{0, 0, 0}, 1.999}});
  EXPECT_NEAR(overhang.max, 1.999 - nearest_face, 1e-6);
  EXPECT_LE(overhang.bound, overhang.max * 1.0001 + 1e-6 * field.diagonal());
}

TEST(Overhang, NothingOutsideIsZero) {
  const Overhang inside = overhangOf(kUnitCube, {{{0.2, 0, 0}, 0.5}, {{0, 0, 0}, 0.9}});
  EXPECT_EQ(inside.max, 0);
  EXPECT_LE(inside.bound, 1e-6 * kCubeDiagonal);
  EXPECT_EQ(inside.p99, 0);
  EXPECT_EQ(inside.mean, 0);
  EXPECT_FALSE(inside.worst_ball);
  EXPECT_EQ(overhangOf(kUnitCube, {}).bound, 0);
}

TEST(Overhang, PartsInsideOtherBallsDoNotCount) {
  // The small ball reaches out of the cube, but only inside the large one.
  const Overhang large = overhangOf(kUnitCube, {{{0, 0, 0}, 1.5}}), both = overhangOf(kUnitCube, {{{0, 0, 0}, 1.5}, {{0.9, 0, 0}, 0.5}});
  EXPECT_EQ(large.max, both.max);
  EXPECT_EQ(large.mean, both.mean);
  // Two balls side by side: their common circle is buried, so that the highest points lie beside it at most.
  const Overhang pair = overhangOf(kUnitCube, {{{-0.5, 0, 0}, 1.3}, {{0.5, 0, 0}, 1.3}});
  EXPECT_NEAR(pair.max, 0.8, 1e-4) << "along x: 0.5 + 1.3 - 1";
}

// A cubic cavity with a ball about the middle of each face: the remaining space is pockets at its corners, and the
// point of a pocket's boundary that is farthest from the walls is the corner where three balls meet. Sampling never
// hits it.
TEST(Overhang, FindsTheCornerWhereThreeBallsMeet) {
  TriangleMesh cavity = kUnitCube;
  for (Triangle& t : cavity.triangles) std::swap(t[1], t[2]);
  const TriangleMesh hollow = test::joined(test::boxMesh({-3, -3, -3}, {3, 3, 3}), cavity);
  for (const double radius : {1.1, 1.2, 1.35}) {
    std::vector<Ball> balls;
    for (int axis = 0; axis < 3; ++axis)
      for (const double sign : {1.0, -1.0}) balls.push_back({sign * Vector3d::Unit(axis), radius});
    const double corner = (1 + std::sqrt(1 + 3 * (radius * radius - 1))) / 3;  // (t - 1)^2 + 2 t^2 = r^2
    const Overhang overhang = overhangOf(hollow, balls);
    EXPECT_NEAR(overhang.max, 1 - corner, 1e-5 * (1 - corner));
    EXPECT_GE(overhang.bound, 1 - corner - 1e-14);
  }
}

class OverhangOfRandomBalls : public testing::TestWithParam<int> {};

TEST_P(OverhangOfRandomBalls, BoundHoldsForEverySampleAndIsTight) {
  test::Random random(static_cast<std::uint64_t>(GetParam()));
  const TriangleMesh mesh = GetParam() % 2 ? test::torusMesh(2, 0.8, 20, 9) : test::sphereMesh(2, 2);
  const DistanceField field(mesh);
  std::vector<Ball> balls;
  const std::size_t count = 1 + random.below(60);
  while (balls.size() < count) {
    const Vector3d centre = random.inCube(3);
    const double distance = field.signedDistance(centre);
    if (distance < 0.2) balls.push_back({centre, std::abs(distance) + random.between(0.01, 0.6)});
  }
  const Overhang overhang = overhangOf(mesh, balls);
  EXPECT_GE(overhang.bound, overhang.max);
  EXPECT_LE(overhang.bound, 1.0001 * overhang.max + 1e-6 * field.diagonal());
  EXPECT_LE(overhang.p99, overhang.max);
  EXPECT_LE(overhang.mean, overhang.p99);
  EXPECT_NEAR(field.signedDistance(overhang.worst_point), overhang.max, 1e-12);
  double highest = 0;
  for (int k = 0; k < 100000; ++k) {
    const Ball& ball = balls[random.below(balls.size())];
    const Vector3d p = ball.centre + ball.radius * random.direction();
    bool covered = false;
    for (const Ball& other : balls) covered = covered || (p - other.centre).norm() < other.radius - 1e-9;
    if (!covered) highest = std::max(highest, field.signedDistance(p));
  }
  EXPECT_LE(highest, overhang.bound);
  EXPECT_LE(highest, overhang.max + 1e-4 * overhang.max);
  EXPECT_GT(highest, 0.9 * overhang.max) << "the oracle must come near";
}

INSTANTIATE_TEST_SUITE_P(Seeds, OverhangOfRandomBalls, testing::Range(1, 13));

TEST(Overhang, ABudgetEndsTheProofWithABoundThatHolds) {
  const TriangleMesh mesh = test::sphereMesh(2, 3);
  const DistanceField field(mesh);
  const SphereUnion balls(std::vector<Ball>{{{0.3, 0.2, 0.1}, 2.3}, {{-0.4, 0, 0.3}, 2.1}});
  Progress progress;
  const Overhang whole = measureOverhang(field, balls, {}, progress);
  for (const std::size_t budget : {0, 20, 100, 1000}) {
    const Overhang cut = measureOverhang(field, balls, {.max_patches = budget}, progress);
    EXPECT_GE(cut.bound, whole.max);
    EXPECT_GE(cut.bound, cut.max);
    EXPECT_LE(cut.bound, 5);
  }
}

TEST(Overhang, CancelsAndRefusesSettingsOutOfRange) {
  const DistanceField field(kUnitCube);
  const SphereUnion balls(std::vector<Ball>{{{0, 0, 0}, 1.5}});
  Progress progress;
  EXPECT_THROW(measureOverhang(field, balls, {.min_per_ball = 0}, progress), std::invalid_argument);
  EXPECT_THROW(measureOverhang(field, balls, {.absolute_gap = 0}, progress), std::invalid_argument);
  progress.cancel();
  EXPECT_THROW(measureOverhang(field, balls, {}, progress), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
