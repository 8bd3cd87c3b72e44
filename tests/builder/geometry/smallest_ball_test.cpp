// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/smallest_ball.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

double farthest(const std::vector<Vector3d>& points, const Vector3d& c) {
  double largest = 0;
  for (const Vector3d& p : points) largest = std::max(largest, (p - c).norm());
  return largest;
}

TEST(SmallestBall, KnownAnswers) {
  EXPECT_EQ(smallestBall({}).radius, 0);
  EXPECT_EQ(smallestBall(std::vector<Vector3d>{{3, 4, 5}}).centre, Vector3d(3, 4, 5));
  const Ball pair = smallestBall(std::vector<Vector3d>{{0, 0, 0}, {2, 0, 0}, {2, 0, 0}});
  EXPECT_NEAR(pair.radius, 1, 1e-12);
  std::vector<Vector3d> cube;
  for (int i = 0; i < 8; ++i) cube.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  const Ball ball = smallestBall(cube);
  EXPECT_NEAR(ball.radius, std::sqrt(0.75), 1e-12);
  EXPECT_LT((ball.centre - Vector3d::Constant(0.5)).norm(), 1e-12);
  const Ball line = smallestBall(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {7, 0, 0}});
  EXPECT_NEAR(line.radius, 3.5, 1e-12);
}

TEST(SmallestBall, HoldsAllAndNoNearbyCentreDoesBetter) {
  test::Random random(1);
  for (int round = 0; round < 200; ++round) {
    std::vector<Vector3d> points;
    const std::size_t count = 1 + random.below(40);
    const bool flat = random.below(4) == 0;
    for (std::size_t i = 0; i < count; ++i) {
      Vector3d p = random.inCube(10);
      if (flat) p.z() = 1;
      if (random.below(5) == 0 && !points.empty()) p = points[random.below(points.size())];  // repeated points
      points.push_back(p);
    }
    const Ball ball = smallestBall(points);
    EXPECT_GE(ball.radius, farthest(points, ball.centre));
    // The largest distance is a convex function of the centre: if no neighbouring centre is better, none is.
    for (int k = 0; k < 200; ++k) {
      const double step = k % 2 == 0 ? 1e-3 : 0.5;
      EXPECT_GE(farthest(points, ball.centre + step * random.direction()), ball.radius * (1 - 1e-9));
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
