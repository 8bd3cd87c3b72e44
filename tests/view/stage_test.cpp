// SPDX-License-Identifier: GPL-3.0-or-later
// The visible form of trees and meshes: stage.h, surface.h
#include "model/stage.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "support/sample_trees.h"
#include "support/shapes.h"

namespace spheretree::view {
namespace {

TEST(Stage, EveryLevelHoldsItsLevelSet) {
  const SphereTree tree = test::threeLevelTree();
  const Body body = bodyOf("tree", &tree, nullptr, {});
  ASSERT_EQ(body.levels.size(), static_cast<std::size_t>(tree.levelCount()));
  for (int level = 0; level < tree.levelCount(); ++level) {
    const std::vector<std::uint32_t> nodes = levelSet(tree, level);
    const auto& balls = body.levels[static_cast<std::size_t>(level)];
    ASSERT_EQ(balls.size(), nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      EXPECT_EQ(balls[k].x, static_cast<float>(tree.cover[nodes[k]].x + tree.origin_mm[0]));
      EXPECT_EQ(balls[k].radius, tree.cover[nodes[k]].radius);
      EXPECT_EQ(body.bounds[static_cast<std::size_t>(level)][k].radius, sphereOf(tree, nodes[k], SphereKind::Bound).radius);
    }
  }
  // The box is that of the leaves, because there is no mesh.
  for (const Ball& ball : body.levels.back()) EXPECT_TRUE(body.box.contains(Eigen::Vector3d(ball.x, ball.y, ball.z)));
}

TEST(Surface, NormalsAreSmoothButForSharpEdges) {
  const TriangleMesh cube = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  const Surface sharp = surfaceOf(cube, 0.8);
  EXPECT_EQ(sharp.indices.size(), 3 * cube.triangles.size());
  for (std::size_t t = 0; t < cube.triangles.size(); ++t) {
    const Eigen::Vector3d face = (cube.corner(t, 1) - cube.corner(t, 0)).cross(cube.corner(t, 2) - cube.corner(t, 0)).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const SurfaceCorner& corner = sharp.corners[sharp.indices[3 * t + k]];
      EXPECT_LT((corner.normal.cast<double>() - face).norm(), 1e-6);
      EXPECT_EQ(corner.position, cube.corner(t, static_cast<int>(k)).cast<float>());
    }
  }
  EXPECT_EQ(sharp.corners.size(), 24u);
  // With a crease of more than a right angle the corners point outward along the diagonals.
  const Surface smooth = surfaceOf(cube, 2);
  EXPECT_EQ(smooth.corners.size(), 8u);
}

TEST(Stage, HeatGrowsBrighterAllTheWay) {
  double last = -1;
  for (int k = 0; k <= 100; ++k) {
    const Colour c = heat(k / 100.0);
    const double brightness = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    EXPECT_GE(brightness, last);
    last = brightness;
  }
  EXPECT_EQ(heat(-1), heat(0));
  EXPECT_EQ(heat(7), heat(1));
}

}  // namespace
}  // namespace spheretree::view
