// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/refit_ball.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "support/dense_points.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

double farthest(std::span<const Vector3d> patch, const Vector3d& c) {
  double largest = 0;
  for (const Vector3d& p : patch) largest = std::max(largest, (p - c).norm());
  return largest;
}

// A disc of points about (x, y) at height z.
std::vector<Vector3d> disc(double x, double y, double z, double radius) {
  std::vector<Vector3d> points{{x, y, z}};
  for (const double r : {0.5 * radius, radius})
    for (int k = 0; k < 48; ++k) {
      const double angle = 2 * std::numbers::pi * k / 48;
      points.emplace_back(x + r * std::cos(angle), y + r * std::sin(angle), z);
    }
  return points;
}

TEST(RefitBall, IsNeverWorseAndTellsTheTruth) {
  const TriangleMesh torus = test::torusMesh(5, 2, 24, 12);
  const DistanceField field(torus);
  const std::vector<Vector3d> surface = test::densePoints(torus, 4, 1);
  test::Random random(2);
  int improved = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Vector3d about = surface[random.below(surface.size())];
    std::vector<Vector3d> patch;
    for (const Vector3d& p : surface)
      if ((p - about).norm() < 1.2) patch.push_back(p);
    Vector3d start = random.inBox({-7, -7, -2}, {7, 7, 2});
    while (!(field.signedDistance(start) < -0.01)) start = random.inBox({-7, -7, -2}, {7, 7, 2});
    const double clearance = -field.signedDistance(start), before = farthest(patch, start) - clearance;
    const Refit refit = refitBall(field, patch, start, clearance, 0.3, 20);
    EXPECT_LE(refit.stand_off, before);
    improved += refit.stand_off < 0.9 * before;
    EXPECT_LT(field.signedDistance(refit.centre), 0);
    EXPECT_NEAR(refit.clearance, test::bruteDistance(torus, refit.centre), 1e-12);
    EXPECT_NEAR(refit.stand_off, farthest(patch, refit.centre) - refit.clearance, 1e-12);
  }
  EXPECT_GT(improved, 30);
}

// At such large coordinates, distances have an error above any margin that is proportional to the distance. A centre
// that moves away from an edge of a cavity keeps its nearest point, so that the bound of the search is the distance
// itself.
TEST(RefitBall, FarFromTheOriginOfCoordinatesAllStaysFinite) {
  test::Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::AngleAxisd turn(random.inBox({0, 0, 0}, {3, 3, 3}).x(), random.inBox({-1, -1, -1}, {1, 1, 1}).normalized());
    const auto placed = [&](const Vector3d& p) -> Vector3d { return turn * p + Vector3d(1e6, -2e6, 3e6); };
    TriangleMesh mesh = test::boxMesh(Vector3d::Constant(-5), Vector3d::Constant(5));
    const TriangleMesh cavity = test::boxMesh(Vector3d::Constant(-0.5), Vector3d::Constant(0.5));
    for (const auto& t : cavity.triangles) mesh.triangles.push_back({t[0] + 8, t[2] + 8, t[1] + 8});
    mesh.positions.insert(mesh.positions.end(), cavity.positions.begin(), cavity.positions.end());
    for (Vector3d& p : mesh.positions) p = placed(p);
    const DistanceField field(mesh);
    const std::vector<Vector3d> patch{placed({0.5, 0.5, -0.3}), placed({0.5, 0.5, 0.3})};
    const Vector3d start = placed({0.51, 0.51, 0});
    const Refit refit = refitBall(field, patch, start, -field.signedDistance(start), 0.1, 20);
    ASSERT_TRUE(refit.centre.allFinite() && std::isfinite(refit.stand_off)) << trial;
    EXPECT_NEAR(refit.clearance, -field.signedDistance(refit.centre), 1e-8);
    EXPECT_LT(refit.stand_off, 0.9 * (farthest(patch, start) + field.signedDistance(start)));
  }
}

// Between two plates the best centre lies in the middle plane above the middle of the patch, for a patch on one plate
// or on both.
TEST(RefitBall, FindsTheMiddleOfASlab) {
  const TriangleMesh slab = test::boxMesh({-20, -20, -1}, {20, 20, 1});
  const DistanceField field(slab);
  const double best = std::hypot(1.0, 1.2) - 1;
  std::vector<Vector3d> one = disc(3, -2, 1, 1.2), both = one;
  for (const Vector3d& p : disc(3, -2, -1, 1.2)) both.push_back(p);
  for (const auto& patch : {one, both})
    for (const Vector3d& start : {Vector3d(3.4, -2.3, 0.5), Vector3d(2.2, -1.8, -0.6), Vector3d(3, -2, 0.9)}) {
      const Refit refit = refitBall(field, patch, start, 1 - std::abs(start.z()), 0.5, 200);
      EXPECT_GE(refit.stand_off, best - 1e-9);
      EXPECT_LT(refit.stand_off, 1.01 * best) << "from " << start.transpose();
    }
}

// A patch around the corner of a cube, against every centre of a fine grid.
TEST(RefitBall, CornerOfACubeAgreesWithAGridSearch) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(cube);
  std::vector<Vector3d> patch;
  for (int i = 0; i <= 6; ++i)
    for (int j = 0; j <= 6; ++j) patch.insert(patch.end(), {{0.05 * i, 0.05 * j, 0}, {0, 0.05 * i, 0.05 * j}, {0.05 * i, 0, 0.05 * j}});
  double best = std::numeric_limits<double>::infinity();
  constexpr int kGrid = 64;
  for (int i = 1; i < kGrid; ++i)
    for (int j = 1; j < kGrid; ++j)
      for (int k = 1; k < kGrid; ++k) {
        const Vector3d c = Vector3d(i, j, k) / kGrid;
        best = std::min(best, farthest(patch, c) + test::boxDistance({0, 0, 0}, {1, 1, 1}, c));
      }
  for (const Vector3d& start : {Vector3d(0.2, 0.2, 0.2), Vector3d(0.45, 0.15, 0.3), Vector3d(0.05, 0.3, 0.1)}) {
    const double clearance = -test::boxDistance({0, 0, 0}, {1, 1, 1}, start);
    EXPECT_LT(refitBall(field, patch, start, clearance, 0.1, 200).stand_off, 1.02 * best) << "from " << start.transpose();
  }
}

TEST(RefitBall, StopsOnceItIsGoodEnough) {
  const TriangleMesh slab = test::boxMesh({-20, -20, -1}, {20, 20, 1});
  const DistanceField field(slab);
  const std::vector<Vector3d> patch = disc(0, 0, 1, 1.2);
  const Vector3d start(0.8, 0, 0.3);
  const Refit whole = refitBall(field, patch, start, 0.7, 0.5, 200), early = refitBall(field, patch, start, 0.7, 0.5, 200, 0.8);
  EXPECT_LE(early.stand_off, 0.8);
  EXPECT_LT(whole.stand_off, 0.6);
  EXPECT_LT(early.work, whole.work);
  const Refit none = refitBall(field, patch, start, 0.7, 0.5, 200, 1e9);
  EXPECT_EQ(none.centre, start);
  EXPECT_EQ(none.work, 0u);
}

TEST(RefitBall, ABallWithoutAPatchStays) {
  const TriangleMesh slab = test::boxMesh({-20, -20, -1}, {20, 20, 1});
  const Refit refit = refitBall(DistanceField(slab), {}, {1, 2, 0.25}, 0.75, 0.5, 20);
  EXPECT_EQ(refit.centre, Vector3d(1, 2, 0.25));
  EXPECT_EQ(refit.clearance, 0.75);
}

}  // namespace
}  // namespace spheretree::builder
