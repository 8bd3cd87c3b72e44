// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/projected_cover.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "support/fan_of_slivers.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

double areaOf(const Corners& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm(); }

double areaLeft(const ProjectedCover& cover) {
  double area = 0;
  for (const Corners& t : cover.not_covered) area += areaOf(t);
  return area;
}

/// Squares of two triangles each, with corners at integers from 0 to `n`, at the given height.
template <class Height>
TriangleMesh gridMesh(std::uint32_t n, Height height) {
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= n; ++i)
    for (std::uint32_t j = 0; j <= n; ++j) mesh.positions.emplace_back(i, j, height(double(i), double(j)));
  for (std::uint32_t i = 0; i < n; ++i)
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * (n + 1) + j, b = a + n + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  return mesh;
}

TEST(CoverByProjection, CoversATriangleAboveAGridExactly) {
  const DistanceField grid(gridMesh(20, [](double, double) { return 0.0; }));
  const Corners triangle{Vector3d(1.3, 1.1, 0.25), Vector3d(18.7, 3.2, 0.25), Vector3d(6.1, 17.9, 0.25)};
  const ProjectedCover near = coverByProjection(triangle, grid, 0.3);
  EXPECT_TRUE(near.not_covered.empty());
  EXPECT_NEAR(near.distance, 0.25, 1e-6);
  EXPECT_NEAR(areaLeft(coverByProjection(triangle, grid, 0.2)), areaOf(triangle), 1e-9) << "too far";
}

TEST(CoverByProjection, CoversATriangleAboveManyTrianglesInAnyOrder) {
  TriangleMesh grid = gridMesh(90, [](double x, double y) { return 0.05 * std::sin(x) * std::sin(y); });
  test::Random random(3);
  for (std::size_t t = grid.triangles.size(); t > 1; --t) std::swap(grid.triangles[t - 1], grid.triangles[random.below(t)]);
  const ProjectedCover cover =
      coverByProjection({Vector3d(1.3, 1.1, 0), Vector3d(88.7, 3.2, 0), Vector3d(26.1, 87.9, 0)}, DistanceField(grid), 0.1);
  EXPECT_TRUE(cover.not_covered.empty());
  EXPECT_GT(cover.distance, 0.049);
  EXPECT_LT(cover.distance, 0.0501);
}

TEST(CoverByProjection, CoversATriangleAboveAFanOfSlivers) {
  constexpr std::uint32_t kSlivers = 6000;  // each 1000 times as long as wide
  const TriangleMesh fan = test::fanOfSlivers(kSlivers);
  const DistanceField field(fan);
  for (const Corners& triangle : {Corners{Vector3d(0.2, -0.4, 0.001), Vector3d(0.9, 0, 0.001), Vector3d(0.2, 0.5, 0.001)},
                                  Corners{Vector3d(-0.6, -0.4, 0.001), Vector3d(0.7, -0.3, 0.001), Vector3d(0.1, 0.8, 0.001)}}) {
    const ProjectedCover cover = coverByProjection(triangle, field, 0.002);
    EXPECT_TRUE(cover.not_covered.empty()) << cover.not_covered.size() << " pieces of " << areaLeft(cover) << " mm^2";
    EXPECT_NEAR(cover.distance, 0.001, 1e-6);
  }
}

TEST(CoverByProjection, TakesTheNearerOfTwoSheets) {
  TriangleMesh sheets = gridMesh(10, [](double, double) { return 0.2; });
  const TriangleMesh near = gridMesh(10, [](double, double) { return -0.1; });
  const auto first = static_cast<std::uint32_t>(sheets.positions.size());
  sheets.positions.insert(sheets.positions.end(), near.positions.begin(), near.positions.end());
  for (const auto& [a, b, c] : near.triangles) sheets.triangles.push_back({first + a, first + b, first + c});
  const ProjectedCover cover =
      coverByProjection({Vector3d(1.3, 1.1, 0), Vector3d(8.7, 3.2, 0), Vector3d(2.1, 7.9, 0)}, DistanceField(sheets), 0.3);
  EXPECT_TRUE(cover.not_covered.empty());
  EXPECT_NEAR(cover.distance, 0.1, 1e-6);
}

TEST(CoverByProjection, LeavesTrianglesBeyondTheSurface) {
  const DistanceField grid(gridMesh(10, [](double, double) { return 0.0; }));
  const Corners triangle{Vector3d(5, 2, 0), Vector3d(15, 2, 0), Vector3d(5, 8, 0)};
  // Beyond x = 10 it is a triangle of half the size.
  EXPECT_NEAR(areaLeft(coverByProjection(triangle, grid, 0.1)), areaOf(triangle) / 4, 1e-8);
}

TEST(CoverByProjection, LeavesTrianglesTooFarUpASlope) {
  const DistanceField grid(gridMesh(10, [](double x, double) { return 0.2 * x; }));
  const Corners triangle{Vector3d(0, 0, 0), Vector3d(10, 0, 0), Vector3d(0, 10, 0)};
  // The grid is 1 above the triangle at x = 5.
  EXPECT_NEAR(areaLeft(coverByProjection(triangle, grid, 1)), areaOf(triangle) / 4, 0.02 * areaOf(triangle));
}

TEST(CoverByProjection, BoundsTheDistanceOfWhatItCovers) {
  test::Random random(4);
  const DistanceField grid(gridMesh(20, [](double x, double y) { return 0.3 * std::sin(x) * std::cos(0.7 * y); }));
  for (int round = 0; round < 50; ++round) {
    Corners triangle;
    for (Vector3d& p : triangle) p = random.inBox({2, 2, -0.2}, {18, 18, 0.2});
    const ProjectedCover cover = coverByProjection(triangle, grid, 0.25);
    EXPECT_LE(cover.distance, 0.25);
    EXPECT_LE(areaLeft(cover), areaOf(triangle) * (1 + 1e-6));
    for (int i = 0; i < 100; ++i) {
      const double u = random.unit(), v = random.unit() * (1 - u);
      const Vector3d p = triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0]);
      bool is_left = false;
      for (const Corners& t : cover.not_covered) is_left |= nearestOnTriangle(p, t[0], t[1], t[2]).distance < 1e-9;
      EXPECT_TRUE(is_left || grid.distance(p) <= cover.distance + 1e-9);
    }
  }
}

TEST(CoverByProjection, OfATriangleWithoutAreaIsLeftWhole) {
  const DistanceField grid(gridMesh(4, [](double, double) { return 0.0; }));
  const ProjectedCover cover = coverByProjection({Vector3d(1, 1, 0), Vector3d(3, 3, 0), Vector3d(2, 2, 0)}, grid, 0.1);
  EXPECT_EQ(cover.not_covered.size(), 1u);
}

}  // namespace
}  // namespace spheretree::builder
