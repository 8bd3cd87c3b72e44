// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/sphere_union.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::vector<Ball> randomBalls(test::Random& random, std::size_t count, double smallest, double largest) {
  std::vector<Ball> balls;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d centre = random.inCube(1);
    balls.push_back({centre, random.between(smallest, largest)});
  }
  return balls;
}

double gapByBruteForce(const std::vector<Ball>& balls, const Vector3d& p) {
  double gap = std::numeric_limits<double>::infinity();
  for (const Ball& ball : balls) gap = std::min(gap, (p - ball.centre).norm() - ball.radius);
  return gap;
}

TEST(SphereUnion, GapIsTheOneOfBruteForce) {
  test::Random random(1);
  for (const std::size_t count : {1, 2, 5, 40, 1000}) {
    const std::vector<Ball> balls = randomBalls(random, count, 0.01, 0.4);
    const SphereUnion set(balls);
    for (int k = 0; k < 500; ++k) {
      const Vector3d p = random.inCube(1.5);
      const double gap = gapByBruteForce(balls, p);
      const SphereUnion::Nearest nearest = set.nearest(p);
      EXPECT_EQ(nearest.gap, gap);
      EXPECT_EQ((p - set.balls()[nearest.ball].centre).norm() - set.balls()[nearest.ball].radius, gap);
      for (const double tolerance : {0.0, 0.01, 0.3})
        if (std::abs(gap - tolerance) > 1e-12) {
          EXPECT_EQ(set.covers(p, tolerance), gap < tolerance);
        }
    }
  }
}

TEST(SphereUnion, GrowingARadiusNeverUncovers) {
  test::Random random(2);
  std::vector<Ball> balls = randomBalls(random, 50, 0.05, 0.3);
  std::vector<Vector3d> points;
  for (int k = 0; k < 2000; ++k) points.push_back(random.inCube(1));
  for (int round = 0; round < 20; ++round) {
    const SphereUnion before(balls);
    balls[random.below(balls.size())].radius *= random.between(1, 1.5);
    const SphereUnion after(balls);
    for (const Vector3d& p : points) {
      EXPECT_LE(after.nearest(p).gap, before.nearest(p).gap);
      if (before.covers(p)) {
        EXPECT_TRUE(after.covers(p));
      }
    }
  }
}

TEST(SphereUnion, CapsAreWhatOtherBallsHold) {
  test::Random random(3);
  const std::vector<Ball> balls = randomBalls(random, 60, 0.05, 0.8);
  const SphereUnion set(balls);
  int buried = 0, free = 0;
  for (std::size_t i = 0; i < set.size(); ++i)
    for (int k = 0; k < 300; ++k) {
      const Vector3d u = random.direction(), p = set.balls()[i].centre + set.balls()[i].radius * u;
      double gap = std::numeric_limits<double>::infinity();
      for (std::size_t j = 0; j < set.size(); ++j)
        if (j != i) gap = std::min(gap, (p - set.balls()[j].centre).norm() - set.balls()[j].radius);
      if (std::abs(gap) < 1e-9) continue;
      EXPECT_EQ(set.capOver(i, u) != nullptr, gap < 0);
      (gap < 0 ? buried : free) += 1;
    }
  EXPECT_GT(buried, 1000);
  EXPECT_GT(free, 1000);
}

TEST(SphereUnion, BuriedTrianglesAreBuriedEverywhere) {
  test::Random random(4);
  const std::vector<Ball> balls = randomBalls(random, 30, 0.3, 0.9);
  const SphereUnion set(balls);
  int buried = 0;
  for (int k = 0; k < 20000; ++k) {
    const std::size_t i = random.below(set.size());
    const Vector3d middle = random.direction();
    const double size = random.between(0.01, 0.8);
    std::array<Vector3d, 3> corner;
    for (Vector3d& u : corner) u = (middle + size * random.inCube(1)).normalized();
    const Vector3d centre = (corner[0] + corner[1] + corner[2]).normalized();
    const double flatness = std::min({corner[0].dot(centre), corner[1].dot(centre), corner[2].dot(centre)});
    if (!(flatness > 0.1) || !set.isBuried(i, corner[0], corner[1], corner[2], flatness)) continue;
    ++buried;
    for (int s = 0; s < 20; ++s) {
      const double a = random.unit(), b = random.unit(), c = random.unit();
      const Vector3d u = (a * corner[0] + b * corner[1] + c * corner[2]).normalized();
      EXPECT_NE(set.capOver(i, u), nullptr);
    }
  }
  EXPECT_GT(buried, 1000);
}

TEST(SphereUnion, RepeatedBallsCountOnceAndInnerOnesAreHidden) {
  const std::vector<Ball> balls{{{0, 0, 0}, 1}, {{0, 0, 0}, 1}, {{0.2, 0, 0}, 0.5}, {{0, 0, 0}, 0.3}, {{0, 0, 0}, 1}, {{3, 0, 0}, 1}};
  const SphereUnion set(balls);
  ASSERT_EQ(set.size(), 4u);
  EXPECT_EQ(set.source(1), 2u);
  EXPECT_EQ(set.source(3), 5u);
  EXPECT_FALSE(set.isHidden(0));
  EXPECT_TRUE(set.isHidden(1));
  EXPECT_TRUE(set.isHidden(2));
  EXPECT_FALSE(set.isHidden(3));
  EXPECT_EQ(set.capOver(0, Vector3d::UnitX()), nullptr) << "the twins do not bury each other";
}

TEST(SphereUnion, NoBallsCoverNothing) {
  const SphereUnion set(std::vector<Ball>{});
  EXPECT_TRUE(std::isinf(set.nearest(Vector3d::Zero()).gap));
  EXPECT_FALSE(set.covers(Vector3d::Zero(), 1e9));
}

TEST(SphereUnion, RefusesInvalidBalls) {
  EXPECT_THROW(SphereUnion(std::vector<Ball>{{{0, 0, 0}, 0}}), std::invalid_argument);
  EXPECT_THROW(SphereUnion(std::vector<Ball>{{{0, NAN, 0}, 1}}), std::invalid_argument);
  EXPECT_THROW(SphereUnion(std::vector<Ball>{{{0, 0, 0}, INFINITY}}), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::builder
