// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/build_hulls.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/hull.h"
#include "hulls/cut_hulls.h"
#include "measure/coverage.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A rod with round ends along z.
TriangleMesh capsuleMesh(double radius, double length) {
  TriangleMesh mesh = test::sphereMesh(radius, 3);
  for (Vector3d& p : mesh.positions)
    if (p.z() > 1e-9) p.z() += length;
  return mesh;
}

TriangleMesh moved(TriangleMesh mesh, double scale, double turn, const Vector3d& by) {
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(turn, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  for (Vector3d& p : mesh.positions) p = scale * (rotation * p) + by;
  return mesh;
}

Hulls build(const TriangleMesh& mesh, double tolerance, const Vector3d& origin = Vector3d::Zero(), std::size_t max_hulls = 60) {
  Progress progress;
  return buildHulls(mesh, DistanceField(mesh), origin, {.tolerance = tolerance, .max_hulls = max_hulls}, progress);
}

std::string unproven(const TriangleMesh& mesh, const Hulls& hulls, const Vector3d& origin = Vector3d::Zero()) {
  Progress progress;
  return findUnproven(mesh, DistanceField(mesh), hulls, origin, progress);
}

TEST(BuildHulls, ACapsuleIsOneHullHoweverItIsTurnedScaledAndMoved) {
  const TriangleMesh mesh = capsuleMesh(1, 8);
  const std::vector<TriangleMesh> variants{mesh, moved(mesh, 1, 0.7, {0, 0, 0}), moved(mesh, 0.2, 1.9, {3, -4, 5})};
  const std::vector<double> tolerances{0.05, 0.05, 0.01};
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const Vector3d origin = i == 2 ? Vector3d(3, -4, 5) : Vector3d::Zero();
    const Hulls hulls = build(variants[i], tolerances[i], origin);
    ASSERT_FALSE(hulls.empty());
    EXPECT_LE(hulls.count, 2u);
    EXPECT_EQ(findFault(hulls), "");
    EXPECT_LE(double{hulls.overhang_bound}, tolerances[i]);
    EXPECT_EQ(unproven(variants[i], hulls, origin), "");
  }
}

// A torus has no straight part: hulls around it, whose surface is sampled densely.
TEST(BuildHulls, NoSampleIsBareAndNoBallReachesOutFarther) {
  const TriangleMesh mesh = test::torusMesh(3, 1, 48, 24);
  const double tolerance = 0.1;
  const Hulls hulls = build(mesh, tolerance);
  ASSERT_FALSE(hulls.empty());
  EXPECT_LE(double{hulls.overhang_bound}, tolerance);
  EXPECT_EQ(unproven(mesh, hulls), "");
  std::vector<HullDistance> parts;
  for (const HullPart& part : hulls.parts) parts.emplace_back(hullOf(hulls, part));
  std::size_t bare = 0;
  for (const SurfacePoint& s : spreadOverSurface(mesh, 20000, 1))
    bare += std::ranges::none_of(parts, [&](const HullDistance& part) { return part(s.point) <= 0; });
  EXPECT_EQ(bare, 0u);
  test::Random random(9);
  const DistanceField field(mesh);
  for (const HullPart& part : hulls.parts)
    for (int i = 0; i < 20; ++i) {
      const Hull hull = hullOf(hulls, part);
      double sum = 0;
      Ball ball{Vector3d::Zero(), 0};
      for (std::size_t k = 0; k < hull.count; ++k) {
        const double w = random.between(0, 1);
        ball.centre += w * hull.ball[k].centre, ball.radius += w * hull.ball[k].radius, sum += w;
      }
      EXPECT_LE(ball.radius / sum + field.signedDistance(ball.centre / sum), double{hulls.overhang_bound});
    }
}

TEST(BuildHulls, TheProofFindsAShrunkBallAMissingPartAndAWrongBound) {
  const TriangleMesh mesh = capsuleMesh(1, 8);
  const Hulls hulls = build(mesh, 0.02);
  ASSERT_FALSE(hulls.empty());
  ASSERT_EQ(unproven(mesh, hulls), "");
  Hulls shrunk = hulls;
  for (Sphere& ball : shrunk.balls) ball.radius *= 0.97f;
  EXPECT_EQ(unproven(mesh, shrunk), "the hulls do not provably cover the surface");
  Hulls without = hulls;
  std::erase_if(without.parts, [](const HullPart& part) { return ballCount(part) > 1; });
  EXPECT_EQ(unproven(mesh, without), "the hulls do not provably cover the surface");
  Hulls wrong = hulls;
  wrong.overhang_bound *= 0.9f;
  EXPECT_EQ(unproven(mesh, wrong), "the hulls reach out by more than their bound");
}

TEST(BuildHulls, TheSameForAnyNumberOfThreads) {
  const TriangleMesh mesh = test::torusMesh(3, 1, 24, 12);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build(mesh, 0.3);
  };
  const Hulls one = with(1);
  EXPECT_FALSE(one.empty());
  EXPECT_TRUE(one == with(2));
  EXPECT_TRUE(one == with(4));
}

TEST(BuildHulls, NoneWhereTheyDoNotPayOrRoundingIsTooCoarse) {
  const TriangleMesh mesh = test::torusMesh(3, 1, 24, 12);
  EXPECT_TRUE(build(mesh, 0.01, Vector3d::Zero(), 3).empty());
  EXPECT_TRUE(build(mesh, 1e-7).empty());
}

TEST(BuildHulls, WithoutAToleranceTheTightestThatTheNumberAllows) {
  const TriangleMesh mesh = capsuleMesh(1, 8);
  const Hulls hulls = build(mesh, 0, Vector3d::Zero(), 1);
  ASSERT_EQ(hulls.count, 1u);
  EXPECT_EQ(unproven(mesh, hulls), "");
  EXPECT_TRUE(build(mesh, 0.8 * double{hulls.overhang_bound}, Vector3d::Zero(), 1).empty()) << "one hull does not do much better";
}

}  // namespace
}  // namespace spheretree::builder
