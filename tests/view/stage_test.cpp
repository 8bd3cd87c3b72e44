// SPDX-License-Identifier: GPL-3.0-or-later
// The visible form of trees and meshes: stage.h, surface.h
#include "model/stage.h"

#include "draw/pick.h"
#include "panel/viewer_state.h"

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

Body ballBody(const char* name, double radius) {
  Body body;
  body.name = name;
  body.levels = {{Ball{0, 0, 0, static_cast<float>(radius), {}}}};
  body.bounds = body.levels;
  body.box = Eigen::AlignedBox3d(Eigen::Vector3d::Constant(-radius), Eigen::Vector3d::Constant(radius));
  return body;
}

/// Two balls along y, the farther one larger, and a tool of one ball.
Stage twoBalls() {
  Stage stage;
  stage.bodies = {ballBody("tool", 1), ballBody("near", 2), ballBody("far", 6)};
  stage.tool = 0;
  stage.objects = {{1, {{0, 10, 0}, {1, 0, 0, 0}}}, {2, {{0, 30, 0}, {1, 0, 0, 0}}}};
  return stage;
}

TEST(Pick, TheFirstShownObjectOnTheRay) {
  const Stage stage = twoBalls();
  Look look;
  ShownState state;
  const Ray middle{{0, -50, 0}, {0, 1, 0}}, aside{{4, -50, 0}, {0, 1, 0}}, past{{9, -50, 0}, {0, 1, 0}}, away{{0, -50, 0}, {0, -1, 0}};
  EXPECT_EQ(pickObject(stage, look, state, middle), 0u);
  EXPECT_EQ(pickObject(stage, look, state, aside), 1u);
  EXPECT_FALSE(pickObject(stage, look, state, past));
  EXPECT_FALSE(pickObject(stage, look, state, away));
  look.hidden = {true};
  EXPECT_EQ(pickObject(stage, look, state, middle), 1u);
}

TEST(Pick, MeshesAreMetOnTheirTriangles) {
  Stage stage = twoBalls();
  const TriangleMesh cube = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  stage.bodies[1].mesh = surfaceOf(cube);
  const Ray beside_the_cube{{1.5, -50, 0}, {0, 1, 0}};  // but through the ball
  EXPECT_EQ(pickObject(stage, {}, {}, beside_the_cube), 1u);
  EXPECT_EQ(pickObject(stage, {}, {}, Ray{{0.5, -50, 0.5}, {0, 1, 0}}), 0u);
  Look look;
  look.objects = Geometry::Spheres;
  EXPECT_EQ(pickObject(stage, look, {}, beside_the_cube), 0u);
}

TEST(Pick, TheGapIsThatOfTheNearestLeaves) {
  const Stage stage = twoBalls();
  ShownState state;
  EXPECT_FALSE(gapToObject(stage, state, 0));
  state.has_tool = true;
  state.graphic.position = {0, 4, 0};
  EXPECT_NEAR(*gapToObject(stage, state, 0), 6 - 1 - 2, 1e-6);
  EXPECT_NEAR(*gapToObject(stage, state, 1), 26 - 1 - 6, 1e-6);
}

TEST(Stage, AMarkAtAReferencePointBesideTheToolIsOnTheTool) {
  Stage stage = twoBalls();
  EXPECT_EQ(stage.toolMark(), Eigen::Vector3d(0, 0, 0)) << "the reference point is in the tool";
  stage.reference_point = {0, 0, 5};
  EXPECT_EQ(stage.toolMark(), Eigen::Vector3d(0, 0, -5));
}

TEST(FirstCamera, ShowsAllTeethAndTheWholeTool) {
  Stage stage = twoBalls();
  stage.bodies[1].is_tooth = true;
  stage.bodies[2].box = Eigen::AlignedBox3d(Eigen::Vector3d::Constant(-90), Eigen::Vector3d::Constant(90));  // a face
  stage.bodies[0].box = Eigen::AlignedBox3d(Eigen::Vector3d(-1, -1, 0), Eigen::Vector3d(1, 1, 34));          // a shaft
  const Viewport viewport{0, 0, 800, 500};
  for (const bool y_up : {false, true}) {
    stage.y_up = y_up;
    const Camera camera = firstCamera(stage, Configuration{{0, 10, 5}, {1, 0, 0, 0}}, viewport);
    EXPECT_EQ(camera.y_up, y_up);
    for (const Eigen::Vector3d& point : {Eigen::Vector3d(0, 10, 39), Eigen::Vector3d(2, 10, 0), Eigen::Vector3d(-2, 10, 0)}) {
      const auto pixel = camera.pixelOf(point, viewport);
      ASSERT_TRUE(pixel);
      EXPECT_TRUE(pixel->x() > 0 && pixel->x() < 800 && pixel->y() > 0 && pixel->y() < 500) << pixel->transpose();
    }
    EXPECT_LT(camera.distance, 150) << "the face is not what one came for";
  }
}

TEST(History, ARunThatBeginsAgainIsAnotherRun) {
  History history;
  for (int n = 0; n < 20; ++n) {
    player::RecordedStep step;
    step.time = 1e-3 * (n < 12 ? n : n - 12);
    history.add(sampleOf(step));
  }
  EXPECT_EQ(history.samples().size(), 8u);
  EXPECT_EQ(history.samples().front().time, 0);
}

}  // namespace
}  // namespace spheretree::view
