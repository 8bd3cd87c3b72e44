// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/farthest_points.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/surface_samples.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> samplesOf(const TriangleMesh& mesh, std::size_t count) {
  SampleSettings sampling;
  sampling.count = count;
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : sampleSurface(mesh, sampling)) points.push_back(s.point);
  return points;
}

double gapOf(const Vector3d& p, const Ball& ball) { return (p - ball.centre).norm() - ball.radius; }

const TriangleMesh kSolids[] = {test::torusMesh(5, 2, 24, 12), test::boxMesh({0, 0, 0}, {6, 2, 1.5}),
                                test::boxMesh({0, 0, 0}, {4, 4, 0.05})};

TEST(FarthestPoints, BallsAreInscribed) {
  for (const TriangleMesh& mesh : kSolids) {
    const DistanceField field(mesh);
    const std::vector<Ball> balls = farthestPointBalls(field, samplesOf(mesh, 1000), 60);
    ASSERT_EQ(balls.size(), 60u);
    for (const Ball& ball : balls) EXPECT_NEAR(ball.radius, -field.signedDistance(ball.centre), 1e-12);
  }
}

// Against a search of all samples and balls: what each ball is added for has the largest gap, and half of it then.
TEST(FarthestPoints, EachBallHalvesTheLargestGap) {
  for (const TriangleMesh& mesh : kSolids) {
    const std::vector<Vector3d> samples = samplesOf(mesh, 1000);
    const std::vector<Ball> balls = farthestPointBalls(DistanceField(mesh), samples, 60);
    std::vector<double> gaps(samples.size(), 1e9);
    for (std::size_t b = 0; b + 1 < balls.size(); ++b) {
      double largest = 0, halved = 1e9;
      for (std::size_t s = 0; s < samples.size(); ++s)
        largest = std::max(largest, gaps[s] = std::min(gaps[s], gapOf(samples[s], balls[b])));
      for (std::size_t s = 0; s < samples.size(); ++s)
        if (gaps[s] == largest) halved = std::min(halved, gapOf(samples[s], balls[b + 1]));
      EXPECT_LE(halved, 0.5 * largest + 1e-3 * balls[b + 1].radius) << b;
    }
  }
}

TEST(FarthestPoints, MoreBallsReachFarther) {
  for (const TriangleMesh& mesh : kSolids) {
    const std::vector<Vector3d> samples = samplesOf(mesh, 2000);
    double last = 1e9;
    for (const std::size_t count : {4, 32, 256}) {
      const std::vector<Ball> balls = farthestPointBalls(DistanceField(mesh), samples, count);
      double largest = 0;
      for (const Vector3d& p : samples) {
        double gap = 1e9;
        for (const Ball& ball : balls) gap = std::min(gap, gapOf(p, ball));
        largest = std::max(largest, gap);
      }
      EXPECT_LT(largest, 0.5 * last) << count;
      last = largest;
    }
  }
}

// At the corners of a cube no ball touches the surface.
TEST(FarthestPoints, NoneWhereNoBallTouches) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(farthestPointBalls(DistanceField(cube), cube.positions, 8).empty());
  EXPECT_TRUE(farthestPointBalls(DistanceField(cube), {}, 8).empty());
}

}  // namespace
}  // namespace spheretree::builder
