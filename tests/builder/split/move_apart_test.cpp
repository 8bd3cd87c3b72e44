// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/move_apart.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <utility>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr std::uint32_t kCells = 12;

/// A square sheet z = 0 of 12 by 12 cells of 1 mm about the origin; the vertices within it are new.
MovableSheet flatSheet(std::vector<Vector3d>& positions) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> at;
  const auto isBorder = [](std::uint32_t i, std::uint32_t j) { return i == 0 || j == 0 || i == kCells || j == kCells; };
  MovableSheet sheet{.edge = 1};
  for (const bool border : {true, false}) {
    if (!border) sheet.first_new = positions.size();
    for (std::uint32_t j = 0; j <= kCells; ++j)
      for (std::uint32_t i = 0; i <= kCells; ++i)
        if (isBorder(i, j) == border) {
          at[{i, j}] = static_cast<std::uint32_t>(positions.size());
          positions.emplace_back(i - 0.5 * kCells, j - 0.5 * kCells, 0);
        }
  }
  for (std::uint32_t j = 0; j < kCells; ++j)
    for (std::uint32_t i = 0; i < kCells; ++i) {
      sheet.triangles.push_back({at[{i, j}], at[{i + 1, j}], at[{i + 1, j + 1}]});
      sheet.triangles.push_back({at[{i, j}], at[{i + 1, j + 1}], at[{i, j + 1}]});
    }
  for (std::size_t t = 0; t < sheet.triangles.size(); ++t) sheet.group.push_back(static_cast<std::uint32_t>(t % 3));
  return sheet;
}

struct Obstacle {
  std::vector<Vector3d> positions;
  std::vector<Triangle> triangles;
  CrossingSearch search{positions, 1};

  explicit Obstacle(const TriangleMesh& mesh) : positions(mesh.positions), triangles(mesh.triangles) {
    for (const Triangle& t : triangles) search.add(t);
  }
  Vector3d normal(std::uint32_t i) const {
    const Triangle& t = triangles[i];
    return (positions[t[1]] - positions[t[0]]).cross(positions[t[2]] - positions[t[0]]).normalized();
  }
};

int moved(TriangleMesh mesh, const Vector3d& by) {
  for (Vector3d& p : mesh.positions) p += by;
  Obstacle obstacle(mesh);
  MovableSheet sheet = flatSheet(obstacle.positions);
  const std::vector<Vector3d> before = obstacle.positions;
  EXPECT_GT(obstacle.search.against(sheet.triangles).size(), 10u);
  // Outside of the ball is right.
  const std::size_t left =
      moveApart(obstacle.positions, sheet, obstacle.search, [&](std::uint32_t i) { return Vector3d(-obstacle.normal(i)); });
  EXPECT_EQ(left, obstacle.search.against(sheet.triangles).size());
  for (std::size_t v = 0; v < sheet.first_new; ++v) EXPECT_EQ(obstacle.positions[v], before[v]) << "of the obstacle and the border";
  EXPECT_EQ(sheet.group.size(), sheet.triangles.size());
  return static_cast<int>(left);
}

TEST(MoveApart, ASheetGoesAroundABall) {
  EXPECT_EQ(moved(test::sphereMesh(2, 3), {0.2, -0.3, 1.6}), 0);
  EXPECT_EQ(moved(test::sphereMesh(2, 3), {0.7, 0.4, -1.5}), 0);
}

// No sheet with this border passes a pole that goes through it and beyond: what is left is said, and is no more than
// before.
TEST(MoveApart, WhereNothingHelpsItKeepsTheBest) {
  TriangleMesh pole = test::boxMesh({0.5, 0.5, 40}, {0.1, 0.1, -20});
  Obstacle obstacle(pole);
  MovableSheet sheet = flatSheet(obstacle.positions);
  const std::size_t before = obstacle.search.against(sheet.triangles).size();
  const std::size_t left =
      moveApart(obstacle.positions, sheet, obstacle.search, [&](std::uint32_t i) { return Vector3d(-obstacle.normal(i)); });
  EXPECT_GT(left, 0u);
  EXPECT_LE(left, before);
  EXPECT_EQ(left, obstacle.search.against(sheet.triangles).size());
}

TEST(SplitEdges, HalvesBothTrianglesAtAnEdge) {
  std::vector<Vector3d> positions;
  MovableSheet sheet = flatSheet(positions);
  const std::size_t triangles = sheet.triangles.size(), vertices = positions.size();
  const Triangle t = sheet.triangles[2 * kCells + 2];
  splitEdges(positions, sheet, [&](std::uint32_t a, std::uint32_t b) { return std::minmax(a, b) == std::minmax(t[0], t[1]); });
  EXPECT_EQ(sheet.triangles.size(), triangles + 2);
  ASSERT_EQ(positions.size(), vertices + 1);
  EXPECT_EQ(positions.back(), (positions[t[0]] + positions[t[1]]) / 2);
  double area = 0;
  for (const Triangle& s : sheet.triangles) {
    const Vector3d twice = (positions[s[1]] - positions[s[0]]).cross(positions[s[2]] - positions[s[0]]);
    EXPECT_GT(twice.z(), 0);
    area += twice.z() / 2;
  }
  EXPECT_DOUBLE_EQ(area, kCells * kCells);
}

}  // namespace
}  // namespace spheretree::builder
