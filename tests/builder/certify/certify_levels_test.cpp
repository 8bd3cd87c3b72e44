// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/certify_levels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "certify/overhang_bound.h"
#include "support/dense_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::vector<Ball> ring(int count, double radius) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    balls.push_back({5 * Vector3d(std::cos(angle), std::sin(angle), 0), radius});
  }
  return balls;
}

struct Torus {
  TriangleMesh mesh = test::torusMesh(5, 1, 48, 16);
  DistanceField field{mesh};
  std::vector<Vector3d> points = test::densePoints(mesh, 20, 3);

  CertifiedLevels certify(const LevelBalls& levels) const {
    Progress progress;
    return certifyLevels({mesh, field, Vector3d::Zero(), 1}, levels, progress);
  }
  double gap(const std::vector<Sphere>& spheres) const { return test::largestGap(points, test::toBalls(spheres)); }
};

TEST(CertifyLevels, EveryLevelCoversAndStatesWhatItsLeavesReach) {
  const Torus torus;
  LevelBalls levels;
  levels.balls = {{{{0, 0, 0}, 6}}, ring(6, 2.5), ring(24, 1.1)};  // the last leaves small gaps
  ASSERT_GT(test::largestGap(torus.points, levels.balls[2]), 0);
  const CertifiedLevels out = torus.certify(levels);
  ASSERT_EQ(out.spheres.size(), 3u);
  for (const std::vector<Sphere>& level : out.spheres) EXPECT_LE(torus.gap(level), 1e-12);
  EXPECT_EQ(out.largest_growth.size(), 3u);
  EXPECT_GT(out.largest_growth[2], 0);
  EXPECT_NEAR(out.uncertified_overhang, 1.1 + torus.field.signedDistance(levels.balls[2][0].centre), 0.02);
  double worst = 0;
  for (const Sphere& s : out.spheres[2]) worst = std::max(worst, overhangBound(torus.field, Vector3d::Zero(), s));
  EXPECT_EQ(out.overhang_bound, worst);
  EXPECT_GE(out.overhang_bound, out.uncertified_overhang);
  EXPECT_EQ(out.count(), out.spheres[0].size() + out.spheres[1].size() + out.spheres[2].size());
}

// Sphere 1 of level 1 has no children, so that it covers its third of the ring on level 2, too.
TEST(CertifyLevels, ABallThatEndsEarlyBelongsToEveryDeeperLevel) {
  const Torus torus;
  LevelBalls levels;
  const std::vector<Ball> all = ring(24, 1.3);
  std::vector<Ball> leaves;
  levels.parents = {{kNone}, {0, 0, 0}, {}};
  levels.balls = {{{{0, 0, 0}, 6.1}}, ring(3, 5.6), {}};
  const Ball& ended = levels.balls[1][1];
  for (const Ball& b : all) {
    if ((b.centre - ended.centre).norm() + 1.2 < ended.radius) continue;
    levels.parents[2].push_back((b.centre - levels.balls[1][0].centre).norm() < (b.centre - levels.balls[1][2].centre).norm() ? 0u : 2u);
    levels.balls[2].push_back(b);
  }
  ASSERT_LT(levels.balls[2].size(), all.size());
  const CertifiedLevels out = torus.certify(levels);
  EXPECT_GT(torus.gap(out.spheres[2]), 0.1) << "not by its own spheres alone";
  std::vector<Sphere> with_ended = out.spheres[2];
  with_ended.push_back(out.spheres[1][1]);
  EXPECT_LE(torus.gap(with_ended), 1e-12);
  EXPECT_LE(torus.gap(out.spheres[1]), 1e-12);
  EXPECT_EQ(out.parents[2].size(), out.spheres[2].size());
}

TEST(CertifyLevels, DropsRedundantLeavesButNoLastChild) {
  const Torus torus;
  LevelBalls levels;
  levels.balls = {{{{0, 0, 0}, 6.1}}, ring(4, 4.2), ring(24, 1.3)};
  levels.balls[2].push_back({5 * Vector3d(std::cos(0.1), std::sin(0.1), 0), 1.25});  // its neighbours cover all of it
  const CertifiedLevels grouped_later = torus.certify(levels);
  EXPECT_LE(grouped_later.spheres[2].size(), 24u);
  EXPECT_LE(torus.gap(grouped_later.spheres[2]), 1e-12);

  levels.parents = {{kNone}, {0, 0, 0, 0}, std::vector<std::uint32_t>(25, 0)};
  for (std::uint32_t i = 1; i < 24; ++i) levels.parents[2][i] = std::min(2u, i / 8);
  levels.parents[2][24] = 3;  // the redundant leaf is the only child of sphere 3
  const CertifiedLevels grouped = torus.certify(levels);
  EXPECT_EQ(std::count(grouped.parents[2].begin(), grouped.parents[2].end(), 3u), 1);
  EXPECT_EQ(grouped.parents[2].size(), grouped.spheres[2].size());
}

}  // namespace
}  // namespace spheretree::builder
