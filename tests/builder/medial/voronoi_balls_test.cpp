// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/voronoi_balls.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/surface_samples.h"
#include "support/dense_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::vector<Vector3d> pointsOf(const TriangleMesh& mesh, std::size_t count) {
  std::vector<Vector3d> points;
  for (const SurfaceSample& s : sampleSurface(mesh, {count, 0.5235987756, 1})) points.push_back(s.point);
  return points;
}

// Points of a cube's surface on a grid: nearly all cells are cospherical with others.
std::vector<Vector3d> gridOnACube(int n) {
  std::vector<Vector3d> points;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k)
        if (i % n == 0 || j % n == 0 || k % n == 0) points.emplace_back(Vector3d(i, j, k) / n);
  return points;
}

TEST(VoronoiBalls, AreInscribed) {
  const TriangleMesh torus = test::torusMesh(5, 2, 24, 12);
  const DistanceField field(torus);
  const std::vector<Ball> balls = voronoiBalls(pointsOf(torus, 600), field);
  ASSERT_GT(balls.size(), 600u);
  for (const Ball& b : balls) {
    EXPECT_NEAR(b.radius, test::bruteDistance(torus, b.centre), 1e-12);
    // Inside the torus of revolution that circumscribes the mesh.
    EXPECT_LT(std::hypot(std::hypot(b.centre.x(), b.centre.y()) - 5, b.centre.z()), 2);
  }
}

// The medial axis of a torus is a circle; balls about it have the minor radius, reduced slightly by the flat faces.
TEST(VoronoiBalls, ReachTheMedialAxis) {
  const TriangleMesh torus = test::torusMesh(5, 2, 48, 24);
  double largest = 0;
  for (const Ball& b : voronoiBalls(pointsOf(torus, 2000), DistanceField(torus))) largest = std::max(largest, b.radius);
  EXPECT_GT(largest, 1.95);
  EXPECT_LE(largest, 2);
}

TEST(VoronoiBalls, CornersOfACubeGiveOneBall) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const std::vector<Ball> balls = voronoiBalls(cube.positions, DistanceField(cube));
  ASSERT_EQ(balls.size(), 1u);
  EXPECT_LT((balls[0].centre - Vector3d(0.5, 0.5, 0.5)).norm(), 1e-12);
  EXPECT_NEAR(balls[0].radius, 0.5, 1e-12);
}

TEST(VoronoiBalls, RepeatedCentresAreLeftOut) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const std::vector<Ball> balls = voronoiBalls(gridOnACube(8), DistanceField(cube));
  ASSERT_FALSE(balls.empty());
  for (std::size_t i = 0; i < balls.size(); ++i) {
    EXPECT_LT(test::boxDistance({0, 0, 0}, {1, 1, 1}, balls[i].centre), 0);
    for (std::size_t j = 0; j < i; ++j) EXPECT_GT((balls[i].centre - balls[j].centre).norm(), 1e-9);
  }
}

TEST(VoronoiBalls, FlatAndFewPointsGiveNone) {
  const TriangleMesh cube = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(cube);
  std::vector<Vector3d> plane, line;
  for (int i = 0; i < 10; ++i) {
    line.emplace_back(0.1 * i, 0.2, 0.3);
    for (int j = 0; j < 10; ++j) plane.emplace_back(0.1 * i, 0.1 * j, 0.5);
  }
  EXPECT_TRUE(voronoiBalls(plane, field).empty());
  EXPECT_TRUE(voronoiBalls(line, field).empty());
  EXPECT_TRUE(voronoiBalls(std::vector<Vector3d>(50, Vector3d(0.1, 0.2, 0.3)), field).empty());
  EXPECT_TRUE(voronoiBalls(std::span(cube.positions).first(3), field).empty());
  EXPECT_TRUE(voronoiBalls({}, field).empty());
}

TEST(VoronoiBalls, SamePointsSameBalls) {
  const TriangleMesh torus = test::torusMesh(5, 2, 24, 12);
  const DistanceField field(torus);
  const std::vector<Vector3d> points = pointsOf(torus, 500);
  const std::vector<Ball> one = voronoiBalls(points, field), two = voronoiBalls(points, field);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].centre, two[i].centre);
    EXPECT_EQ(one[i].radius, two[i].radius);
  }
}

}  // namespace
}  // namespace spheretree::builder
