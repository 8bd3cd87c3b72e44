// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/cover/capsule_row.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/random.h"

namespace spheretree::robot {
namespace {

/// A point of the surface of a capsule.
Eigen::Vector3d surfacePoint(const LinkCapsule& capsule, test::Random& random) {
  const Eigen::Vector3d along = capsule.b - capsule.a, side = random.direction();
  if (along.norm() == 0) return capsule.a + capsule.radius * side;
  if (random.unit() < 0.5) {
    const Eigen::Vector3d across = (side - side.dot(along) / along.squaredNorm() * along).normalized();
    return capsule.a + random.unit() * along + capsule.radius * across;
  }
  return (side.dot(along) > 0 ? capsule.b : capsule.a) + capsule.radius * side;
}

double gap(const Eigen::Vector3d& p, const std::vector<LinkBall>& balls) {
  double best = INFINITY;
  for (const LinkBall& ball : balls) best = std::min(best, (p - ball.centre).norm() - ball.radius);
  return best;
}

double distanceFromSegment(const Eigen::Vector3d& p, const LinkCapsule& capsule) {
  const Eigen::Vector3d along = capsule.b - capsule.a;
  const double at = along.norm() == 0 ? 0 : std::clamp((p - capsule.a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - capsule.a - at * along).norm();
}

TEST(CapsuleRow, CoversTheCapsuleAndReachesOutByTheBound) {
  test::Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d a = random.inCube(300);
    const LinkCapsule capsule{a, a + std::exp(random.between(-3, 7)) * random.direction(), std::exp(random.between(-2, 5))};
    for (const std::size_t count : {1u, 2u, 3u, 8u, 50u}) {
      const BallRow row = ballRow(capsule, count);
      ASSERT_EQ(row.balls.size(), count);
      for (int sample = 0; sample < 200; ++sample) EXPECT_LE(gap(surfacePoint(capsule, random), row.balls), 0);
      for (const LinkBall& ball : row.balls)
        EXPECT_LE(distanceFromSegment(ball.centre, capsule) + ball.radius - capsule.radius,
                  row.overhang + 1e-12 * (capsule.radius + capsule.b.norm()));
    }
  }
}

TEST(CapsuleRow, NoSmallerOverhangIsPossible) {
  // Balls of radius r + h - e in the same number leave a point of the capsule bare, wherever they stand along it: the
  // lengths that they can cover add up to less than the segment.
  test::Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    const double r = std::exp(random.between(-2, 5)), length = std::exp(random.between(-3, 7));
    const LinkCapsule capsule{{0, 0, 0}, {0, 0, length}, r};
    for (const std::size_t count : {1u, 2u, 3u, 8u, 50u}) {
      const double h = ballRow(capsule, count).overhang - 1e-6 * (r + length);
      if (!(h > 0)) continue;
      EXPECT_LT(2 * h + 2 * (static_cast<double>(count) - 1) * std::sqrt(h * h + 2 * r * h), length);
    }
  }
}

TEST(CapsuleRow, KnownValues) {
  // One ball about the middle; two of length 3, 4, 5: h = L^2 / (8 r + 4 L).
  EXPECT_NEAR(ballRow({{0, 0, -60}, {0, 0, 60}, 30}, 1).overhang, 60, 1e-6);
  EXPECT_NEAR(ballRow({{0, 0, -60}, {0, 0, 60}, 30}, 2).overhang, 20, 1e-6);
  const BallRow ball = ballRow({{1, 2, 3}, {1, 2, 3}, 7}, 1);
  EXPECT_EQ(ball.balls.size(), 1u);
  EXPECT_EQ(ball.balls[0].radius, 7);
  EXPECT_EQ(ball.overhang, 0);
}

TEST(CapsuleRow, TheFewestBallsForAnOverhang) {
  test::Random random(3);
  for (int trial = 0; trial < 500; ++trial) {
    const LinkCapsule capsule{{0, 0, 0}, std::exp(random.between(-3, 7)) * random.direction(), std::exp(random.between(-2, 5))};
    const double wanted = std::exp(random.between(-3, 4));
    const std::size_t count = ballsForOverhang(capsule, wanted, 4096);
    if (count < 4096) {
      EXPECT_LE(ballRow(capsule, count).overhang, wanted);
    }
    if (count > 1) {
      EXPECT_GT(ballRow(capsule, count - 1).overhang, wanted * (1 - 1e-9));
    }
  }
  EXPECT_EQ(ballsForOverhang({{0, 0, 0}, {0, 0, 1e9}, 1}, 1e-9, 4096), 4096u);
  EXPECT_EQ(ballsForOverhang({{0, 0, 0}, {0, 0, 0}, 1}, 1e-9, 4096), 1u);
}

}  // namespace
}  // namespace spheretree::robot
