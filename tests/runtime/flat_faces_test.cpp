// SPDX-License-Identifier: Apache-2.0
#include "flat_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::Random;

constexpr double kNoise = 0.02, kTolerance = 0.05;

double top(const Sphere& s, const Vector3d& n) { return n.dot(Vector3d(s.x, s.y, s.z)) + static_cast<double>(s.radius); }

/// Nine times nine balls along each face of a cube from -10 to 10, their tops up to kNoise below it.
std::vector<Sphere> noisyCube() {
  Random random(1);
  std::vector<Sphere> balls;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = -4; i <= 4; ++i)
        for (int j = -4; j <= 4; ++j) {
          const double r = random.between(1, 1.5), room = 10 - kNoise - r;
          Vector3d c;
          c[axis] = side * (10 - r - random.between(0, kNoise));
          c[(axis + 1) % 3] = std::clamp(2.2 * i + random.between(-0.2, 0.2), -room, room);
          c[(axis + 2) % 3] = std::clamp(2.2 * j + random.between(-0.2, 0.2), -room, room);
          balls.push_back(test::ball(c.x(), c.y(), c.z(), r));
        }
  return balls;
}

/// Lies on the balls.
Plane planeOn(std::span<const Sphere> balls, const Vector3d& normal) {
  Plane plane{normal, 0};
  for (const Sphere& s : balls) plane.height = std::max(plane.height, top(s, normal));
  return plane;
}

TEST(FlatFaces, TopsOfACubeComeIntoSixPlanes) {
  const std::vector<Sphere> balls = noisyCube();
  Random random(2);
  std::vector<Plane> planes;  // as a hull has them: none is quite right
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int k = 0; k < 10; ++k)
        planes.push_back(planeOn(balls, (side * Vector3d::Unit(axis) + test::randomPoint(random, 1e-3)).normalized()));
  const std::vector<Sphere> flat = levelled(balls, planes, kTolerance);
  ASSERT_EQ(flat.size(), balls.size());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    const Vector3d way = Vector3d(flat[i].x, flat[i].y, flat[i].z) - Vector3d(balls[i].x, balls[i].y, balls[i].z);
    EXPECT_LE(way.norm() + std::abs(static_cast<double>(flat[i].radius - balls[i].radius)), kFarthestMove * kTolerance + 1e-5);
  }
  for (std::size_t first = 0; first < planes.size(); first += 10) {
    const auto inPlane = [&](std::span<const Sphere> of, const Plane& p) {  // or all but, as nothing stands out of it
      const double height = planeOn(of, p.normal).height;
      return std::count_if(of.begin(), of.end(), [&](const Sphere& s) { return top(s, p.normal) > height - 2e-5; });
    };
    std::ptrdiff_t before = 0, after = 0;
    for (std::size_t k = first; k < first + 10; ++k) {
      before = std::max(before, inPlane(balls, planes[k]));
      after = std::max(after, inPlane(flat, planes[k]));
    }
    EXPECT_LE(before, 3) << first;
    EXPECT_GE(after, 81) << first;
  }
}

TEST(FlatFaces, ABallBetweenTwoFacesGrows) {
  // A plate of one layer: each ball has both faces.
  Random random(3);
  std::vector<Sphere> balls;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) balls.push_back(test::ball(2 * i, 2 * j, random.between(0, kNoise), 2 - random.between(0, kNoise)));
  const std::vector<Plane> planes{planeOn(balls, Vector3d::UnitZ()), planeOn(balls, -Vector3d::UnitZ())};
  const std::vector<Sphere> flat = levelled(balls, planes, kTolerance);
  ASSERT_EQ(flat.size(), balls.size());
  for (const Sphere& s : flat)
    for (const Plane& p : planes) EXPECT_NEAR(top(s, p.normal), p.height, 1e-5);
}

TEST(FlatFaces, WhatIsRoundStaysAsItIs) {
  std::vector<Sphere> balls;
  const SphereTree round = test::ellipsoidTree({9, 7, 6}, 300, 1.2);
  for (std::size_t n = 0; n < round.nodeCount(); ++n)
    if (round.isLeaf(n)) balls.push_back(round.cover[n]);
  std::vector<Plane> planes;
  for (const Sphere& s : balls) planes.push_back(planeOn(balls, Vector3d(s.x, s.y, s.z).normalized()));
  EXPECT_TRUE(levelled(balls, planes, 0.03).empty());
  EXPECT_TRUE(levelled({}, {}, 0.03).empty());
}

}  // namespace
}  // namespace spheretree::runtime
