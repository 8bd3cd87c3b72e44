// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/smallest_enclosing_ball.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "support/random.h"
#include "support/sample_trees.h"

namespace spheretree {
namespace {

/// The radius about the centre of `from` that encloses all of `to`.
double radiusAround(const Sphere& from, const Sphere& to) {
  return std::hypot(double{to.x} - from.x, double{to.y} - from.y, double{to.z} - from.z) + to.radius;
}

TEST(SmallestEnclosing, GivesTheBallOfTwoBallsInClosedForm) {
  const Sphere ball = smallestEnclosing(std::vector<Sphere>{{0, 0, 0, 1}, {10, 0, 0, 2}});
  EXPECT_NEAR(ball.radius, 6.5, 1e-6);  // (1 + 10 + 2) / 2
  EXPECT_NEAR(ball.x, 5.5, 1e-6);
}

TEST(SmallestEnclosing, KeepsABallThatHoldsAllOthers) {
  const Sphere ball = smallestEnclosing(std::vector<Sphere>{{1, 2, 3, 10}, {1, 2, 4, 1}, {0, 2, 3, 8.9f}});
  EXPECT_EQ(ball.x, 1);
  EXPECT_GE(ball.radius, 10);
  EXPECT_LE(ball.radius, std::nextafter(10.0f, 11.0f));
}

/// A lower and an upper bound of the radius of any ball that encloses `balls`: Badoiu and Clarkson's steps towards the
/// farthest ball give a centre; the convex combination of the balls visited gives the dual bound.
struct Optimum {
  double low, high;
};
Optimum enclosingRadius(const std::vector<Sphere>& balls, int steps) {
  // Dual: max over weights w of sum w_i |c_i|^2 - |sum w_i c_i|^2 for points; for balls, take points on the spheres
  // that lie farthest from the present centre: any ball around the balls holds those points too.
  Sphere c = balls[0];
  double x = c.x, y = c.y, z = c.z, high = std::numeric_limits<double>::infinity(), low = 0;
  double sx = 0, sy = 0, sz = 0, s2 = 0, weight = 0;
  for (int step = 0; step < steps; ++step) {
    double far = -1, px = 0, py = 0, pz = 0;
    for (const Sphere& b : balls) {
      const double dx = b.x - x, dy = b.y - y, dz = b.z - z, d = std::sqrt(dx * dx + dy * dy + dz * dz);
      if (d + b.radius <= far) continue;
      far = d + b.radius;
      const double k = d > 0 ? 1 + b.radius / d : 1;
      px = x + dx * k, py = y + dy * k, pz = z + dz * k;
    }
    high = std::min(high, far);
    const double f = 1.0 / (step + 2);
    x += (px - x) * f, y += (py - y) * f, z += (pz - z) * f;
    if (step >= steps / 2) {  // early points are far from the optimum's
      sx += px, sy += py, sz += pz, s2 += px * px + py * py + pz * pz, weight += 1;
      low = std::sqrt(std::max(0.0, s2 / weight - (sx * sx + sy * sy + sz * sz) / (weight * weight)));
    }
  }
  return {low, high};
}

TEST(SmallestEnclosing, IsNearTheOptimumThatAnotherMethodProves) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const std::vector<Sphere> balls = test::randomTree(seed, 4, 8).cover;
    if (balls.size() == 1) continue;
    const Optimum optimum = enclosingRadius(balls, 20000);
    ASSERT_LT(optimum.high, optimum.low * 1.01) << "the yardstick itself is too loose to show anything";
    const Sphere ball = smallestEnclosing(balls);
    EXPECT_GE(ball.radius, optimum.low);
    EXPECT_LE(ball.radius, optimum.high * 1.0001) << "seed " << seed;
  }
}

TEST(SmallestEnclosing, SurvivesBallsThatCoincideOrLieOnALine) {
  for (const int kind : {0, 1, 2, 3}) {
    std::vector<Sphere> balls(50);
    for (std::size_t i = 0; i < balls.size(); ++i) {
      const auto t = static_cast<float>(i);
      if (kind == 0) balls[i] = {1, 2, 3, 1};                          // all the same
      if (kind == 1) balls[i] = {t, 2 * t, -t, 1};                     // on a line
      if (kind == 2) balls[i] = {std::cos(t), std::sin(t), 0, 1e-3f};  // on a circle
      if (kind == 3) balls[i] = {t * 1e-6f + 1000, 0, 0, 1e-5f};       // far from the origin, tiny
    }
    const Sphere enclosing = smallestEnclosing(balls);
    double largest = 0;
    for (const Sphere& a : balls) {
      EXPECT_LE(radiusAround(enclosing, a), enclosing.radius * (1 + 1e-15)) << "kind " << kind;
      for (const Sphere& b : balls) largest = std::max(largest, (radiusAround(a, b) + a.radius) / 2);
    }
    EXPECT_LE(enclosing.radius, largest * 1.1548 + 1e-4) << "kind " << kind;  // Jung's theorem: sqrt(4/3) of half the diameter
  }
}

TEST(SmallestEnclosing, IsInfiniteIfTheRadiusFitsNoFloat) {
  const float far = std::numeric_limits<float>::max();
  EXPECT_EQ(smallestEnclosing(std::vector<Sphere>{{far, 0, 0, far}, {-far, 0, 0, far}}).radius, std::numeric_limits<float>::infinity());
}

TEST(SmallestEnclosing, BallOfPointsInClosedForm) {
  using Eigen::Vector3d;
  EXPECT_EQ(smallestEnclosing(std::vector<Vector3d>{}).radius, 0);
  EXPECT_EQ(smallestEnclosing(std::vector<Vector3d>{{3, 4, 5}}).centre, Vector3d(3, 4, 5));
  const Ball pair = smallestEnclosing(std::vector<Vector3d>{{0, 0, 0}, {2, 0, 0}, {2, 0, 0}});
  EXPECT_NEAR(pair.radius, 1, 1e-12);
  std::vector<Vector3d> cube;
  for (int i = 0; i < 8; ++i) cube.emplace_back(i & 1, (i >> 1) & 1, (i >> 2) & 1);
  const Ball ball = smallestEnclosing(cube);
  EXPECT_NEAR(ball.radius, std::sqrt(0.75), 1e-12);
  EXPECT_LT((ball.centre - Vector3d::Constant(0.5)).norm(), 1e-12);
  const Ball line = smallestEnclosing(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {7, 0, 0}});
  EXPECT_NEAR(line.radius, 3.5, 1e-12);
}

// In double precision, of balls and of points (balls of radius 0), some of them flat and some repeated.
TEST(SmallestEnclosing, EnclosesAllAndNoNearbyCentreDoesBetter) {
  test::Random random(1);
  for (int round = 0; round < 400; ++round) {
    const bool flat = random.below(4) == 0, are_points = round % 2 == 0;
    std::vector<Ball> balls(1 + random.below(40));
    for (std::size_t i = 0; i < balls.size(); ++i) {
      balls[i] = {random.inCube(10), are_points ? 0 : 3 * random.unit()};
      if (flat) balls[i].centre.z() = 1;
      if (random.below(5) == 0) balls[i] = balls[random.below(i + 1)];
    }
    std::vector<Eigen::Vector3d> points;
    for (const Ball& b : balls) points.push_back(b.centre);
    const auto reach = [&](const Eigen::Vector3d& c) {
      double largest = 0;
      for (const Ball& b : balls) largest = std::max(largest, (b.centre - c).norm() + b.radius);
      return largest;
    };
    const Ball ball = are_points ? smallestEnclosing(points) : smallestEnclosing(balls);
    EXPECT_GE(ball.radius, reach(ball.centre) * (1 - 1e-15));
    // The largest distance is a convex function of the centre: if no neighbouring centre is better, none is.
    for (int k = 0; k < 200; ++k) {
      const double step = k % 2 == 0 ? 1e-3 : 0.5;
      EXPECT_GE(reach(ball.centre + step * random.direction()), ball.radius * (1 - 1e-9)) << "round " << round;
    }
  }
}

}  // namespace
}  // namespace spheretree
