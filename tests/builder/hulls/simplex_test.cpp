// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/simplex.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "support/shapes.h"
#include "support/smooth_shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A chord of a ring with the half angle a between its balls is R (1 - cos a) inside of the ring's axis, and reaches out
// by about as much.
TEST(Simplex, AConeAcrossABendIsLeftForItsBalls) {
  const TriangleMesh ring = test::torusMesh(5, 1, 128, 64);
  const DistanceField field(ring);
  const auto ballAt = [&](double angle) {
    const Vector3d c(5 * std::cos(angle), 5 * std::sin(angle), 0);
    return Ball{c, -field.signedDistance(c)};
  };
  const double sag = 5 * (1 - std::cos(0.2));
  const std::vector<NumberedBall> ends{{7, ballAt(-0.2)}, {3, ballAt(0.2)}};
  const std::vector<Simplex> cone = simplicesOf(field, ends, 1.2 * sag), balls = simplicesOf(field, ends, 0.8 * sag);
  ASSERT_EQ(cone.size(), 1u);
  EXPECT_EQ(cone[0].hull.count, 2u);
  EXPECT_EQ(cone[0].corner[0], 3u) << "ascending";
  EXPECT_NEAR(cone[0].overhang, sag, 0.02 * sag);
  ASSERT_EQ(balls.size(), 2u);
  EXPECT_EQ(balls[0].hull.count, 1u);
}

TEST(Simplex, TheTriangulationOfAPlateIsOfSlabsThatLieInNoOther) {
  const TriangleMesh plate = test::boxMesh({0, 0, 0}, {20, 20, 2});
  const DistanceField field(plate);
  std::vector<Ball> balls;
  for (const double x : {3.0, 8.0, 16.0})
    for (const double y : {2.0, 9.0, 17.0}) balls.push_back({{x, y + 0.1 * x, 1}, 1});
  const std::vector<Simplex> all = triangulated(field, balls, 1e-9);
  std::set<std::uint32_t> seen;
  std::size_t last = 3;
  for (const Simplex& s : all) {
    EXPECT_LE(s.hull.count, last) << "those with the most corners first";
    last = s.hull.count;
    seen.insert(s.corners().begin(), s.corners().end());
    for (const Simplex& other : all) EXPECT_FALSE(&s != &other && s.isIn(other));
  }
  EXPECT_EQ(all.front().hull.count, 3u);
  EXPECT_EQ(seen.size(), balls.size());
}

}  // namespace
}  // namespace spheretree::builder
