// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/projected_cover.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <utility>

#include "base/ball.h"
#include "support/fan_of_slivers.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using Corners = std::array<Vector3d, 3>;

Vector3d normalOf(const Corners& triangle) { return (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]); }

/// As the bound of a simplification takes it: from the triangle that is nearest to the middle.
double coverDistance(const Corners& triangle, const Vector3d& along, const DistanceField& field, double allowed) {
  return ProjectedCover(field).distance(triangle, along, field.nearest((triangle[0] + triangle[1] + triangle[2]) / 3).triangle, 0, allowed);
}
double coverDistance(const Corners& triangle, const DistanceField& field, double allowed) {
  return coverDistance(triangle, normalOf(triangle), field, allowed);
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

TEST(ProjectedCover, CoversATriangleAboveAGridExactly) {
  const DistanceField grid(gridMesh(20, [](double, double) { return 0.0; }));
  const Corners triangle{Vector3d(1.3, 1.1, 0.25), Vector3d(18.7, 3.2, 0.25), Vector3d(6.1, 17.9, 0.25)};
  EXPECT_NEAR(coverDistance(triangle, grid, 0.3), 0.25, 1e-9);
  EXPECT_NEAR(coverDistance({triangle[1], triangle[0], triangle[2]}, grid, 0.3), 0.25, 1e-9) << "from below";
  EXPECT_EQ(coverDistance(triangle, grid, 0.2), kInfinity) << "too far";
  EXPECT_NEAR(coverDistance({Vector3d(1.2, 1.1, 0.25), Vector3d(1.3, 1.1, 0.25), Vector3d(1.2, 1.15, 0.25)}, grid, 0.3), 0.25, 1e-9);
}

TEST(ProjectedCover, CoversATriangleAboveManyTrianglesInAnyOrder) {
  TriangleMesh grid = gridMesh(90, [](double x, double y) { return 0.05 * std::sin(x) * std::sin(y); });
  test::Random random(3);
  for (std::size_t t = grid.triangles.size(); t > 1; --t) std::swap(grid.triangles[t - 1], grid.triangles[random.below(t)]);
  const double distance = coverDistance({Vector3d(1.3, 1.1, 0), Vector3d(88.7, 3.2, 0), Vector3d(26.1, 87.9, 0)}, DistanceField(grid), 0.1);
  EXPECT_GT(distance, 0.049);
  EXPECT_LT(distance, 0.0501);
}

TEST(ProjectedCover, CoversATriangleAboveAFanOfSlivers) {
  constexpr std::uint32_t kSlivers = 6000;  // each 1000 times as long as wide
  const DistanceField field(test::fanOfSlivers(kSlivers));
  for (const Corners& triangle : {Corners{Vector3d(0.2, -0.4, 0.001), Vector3d(0.9, 0, 0.001), Vector3d(0.2, 0.5, 0.001)},
                                  Corners{Vector3d(-0.6, -0.4, 0.001), Vector3d(0.7, -0.3, 0.001), Vector3d(0.1, 0.8, 0.001)}})
    EXPECT_NEAR(coverDistance(triangle, field, 0.002), 0.001, 1e-6);
}

// Folds whose projections overlap: each point is covered once more from above than from below.
TEST(ProjectedCover, CoversATriangleAboveFolds) {
  for (const double shift : {0.5, 1.0, 1.5}) {
    TriangleMesh folded = gridMesh(20, [](double x, double) { return std::fmod(x, 2) < 0.5 ? 0.0 : 0.1; });
    for (Vector3d& p : folded.positions) p.x() += p.z() > 0.05 ? -shift : 0;
    const Corners triangle{Vector3d(3.3, 1.1, 0), Vector3d(15.7, 3.2, 0), Vector3d(6.1, 17.9, 0)};
    EXPECT_NEAR(coverDistance(triangle, DistanceField(folded), 0.2), 0.1, 2e-4) << shift;
  }
}

// The faces of a box end at its edges, beyond which the surface turns away.
TEST(ProjectedCover, AFaceIsCoveredUpToItsSharpEdges) {
  TriangleMesh fine = test::boxMesh({0, 0, 0}, {1, 2, 3});
  const TriangleMesh coarse = fine;
  for (int i = 0; i < 3; ++i) fine = test::quartered(fine);
  const DistanceField field(fine);
  for (std::size_t t = 0; t < coarse.triangles.size(); ++t)
    EXPECT_LE(coverDistance({coarse.corner(t, 0), coarse.corner(t, 1), coarse.corner(t, 2)}, field, 0.01), 1e-10);
}

TEST(ProjectedCover, TakesTheNearerOfTwoSheets) {
  TriangleMesh sheets = gridMesh(10, [](double, double) { return 0.2; });
  const TriangleMesh near = gridMesh(10, [](double, double) { return -0.1; });
  const auto first = static_cast<std::uint32_t>(sheets.positions.size());
  sheets.positions.insert(sheets.positions.end(), near.positions.begin(), near.positions.end());
  for (const auto& [a, b, c] : near.triangles) sheets.triangles.push_back({first + a, first + b, first + c});
  EXPECT_NEAR(coverDistance({Vector3d(1.3, 1.1, 0), Vector3d(8.7, 3.2, 0), Vector3d(2.1, 7.9, 0)}, DistanceField(sheets), 0.3), 0.1, 1e-9);
}

TEST(ProjectedCover, RefusesWhatIsNotCovered) {
  const DistanceField grid(gridMesh(10, [](double, double) { return 0.0; }));
  EXPECT_EQ(coverDistance({Vector3d(5, 2, 0), Vector3d(15, 2, 0), Vector3d(5, 8, 0)}, grid, 0.1), kInfinity) << "beyond a border";
  EXPECT_EQ(coverDistance({Vector3d(1, 1, 0), Vector3d(3, 3, 0), Vector3d(2, 2, 0)}, grid, 0.1), kInfinity) << "without area";
  const Corners small{Vector3d(5, 2, 0), Vector3d(6, 2, 0), Vector3d(5, 3, 0)};
  EXPECT_EQ(ProjectedCover(grid).distance(small, normalOf(small), 0, 0, 0.1), kInfinity) << "from a triangle beside it";
  for (const Vector3d& along : {Vector3d(1, 0, 0), Vector3d(1, 2, 1e-12), Vector3d(0, 0, 0)})
    EXPECT_EQ(coverDistance(small, along, grid, 0.1), kInfinity) << "along its plane";
  const DistanceField slope(gridMesh(10, [](double x, double) { return 0.2 * x; }));
  EXPECT_EQ(coverDistance({Vector3d(0, 0, 0), Vector3d(10, 0, 0), Vector3d(0, 10, 0)}, slope, 1), kInfinity) << "too far up a slope";
}

// A triangle in the plane of a face, with a corner beyond a sharp edge: along its normal, all of the wall lies there.
TEST(ProjectedCover, CoversWhatIsBeyondACreaseAlongAnObliqueDirection) {
  const DistanceField box(test::boxMesh({0, 0, 0}, {1, 2, 3}));
  const Corners triangle{Vector3d(0.2, 0.5, 3), Vector3d(1.01, 1, 3), Vector3d(0.2, 1.5, 3)};
  EXPECT_EQ(coverDistance(triangle, box, 0.02), kInfinity);
  EXPECT_NEAR(coverDistance(triangle, {1, 0, 1}, box, 0.02), 0.01, 1e-9);
  EXPECT_NEAR(coverDistance(triangle, {-2, 0, -1}, box, 0.02), 0.01, 1e-9) << "its length and sign do not matter";
  EXPECT_EQ(coverDistance(triangle, {-1, 0, 1}, box, 0.02), kInfinity) << "the wall lies over the triangle";
}

TEST(ProjectedCover, BoundsTheDistanceOfEachPoint) {
  test::Random random(4), directions(5);
  const DistanceField grid(gridMesh(20, [](double x, double y) { return 0.3 * std::sin(x) * std::cos(0.7 * y); }));
  int covered = 0, covered_obliquely = 0;
  for (int round = 0; round < 50; ++round) {
    Corners triangle;
    for (Vector3d& p : triangle) p = random.inBox({2, 2, -0.2}, {18, 18, 0.2});
    const double bound = coverDistance(triangle, grid, 0.5);
    const double oblique = coverDistance(triangle, directions.inBox({-0.5, -0.5, 1}, {0.5, 0.5, 1}), grid, 0.5);
    covered += bound < kInfinity;
    covered_obliquely += oblique < kInfinity;
    double largest = 0;
    for (int i = 0; i < 1000; ++i) {
      const double u = random.unit(), v = random.unit() * (1 - u);
      largest = std::max(largest, grid.distance(triangle[0] + u * (triangle[1] - triangle[0]) + v * (triangle[2] - triangle[0])));
    }
    EXPECT_LE(largest, bound + 1e-9);
    EXPECT_LE(largest, oblique + 1e-9);
    EXPECT_TRUE(bound == kInfinity || bound <= 1.25 * largest) << bound << ", " << largest;
  }
  EXPECT_GT(covered, 25);
  EXPECT_GT(covered_obliquely, 15);
}

}  // namespace
}  // namespace spheretree::builder
