// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace spheretree::view {
namespace {

using Eigen::Vector3d;
constexpr double kHalfTurn = std::numbers::pi;

TEST(Camera, FixedViewsLookAlongTheAxes) {
  const std::array<std::array<Vector3d, 3>, 6> expected{{{Vector3d(0, -1, 0), Vector3d(1, 0, 0), Vector3d(0, 0, 1)},
                                                         {Vector3d(0, 1, 0), Vector3d(-1, 0, 0), Vector3d(0, 0, 1)},
                                                         {Vector3d(-1, 0, 0), Vector3d(0, -1, 0), Vector3d(0, 0, 1)},
                                                         {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1)},
                                                         {Vector3d(0, 0, 1), Vector3d(1, 0, 0), Vector3d(0, 1, 0)},
                                                         {Vector3d(0, 0, -1), Vector3d(1, 0, 0), Vector3d(0, -1, 0)}}};
  for (int side = 1; side <= 6; ++side) {
    Camera camera;
    camera.lookFrom(side);
    const auto& [towards, right, up] = expected[static_cast<std::size_t>(side - 1)];
    EXPECT_LT((camera.towardsEye() - towards).norm(), 1e-12) << side;
    EXPECT_LT((camera.right() - right).norm(), 1e-12) << side;
    EXPECT_LT((camera.up() - up).norm(), 1e-12) << side;
  }
}

TEST(Camera, TheYAxisPointsUpWhereItShould) {
  Camera camera;
  camera.y_up = true;
  camera.lookFrom(1);  // glTF: the front of a model looks along z
  EXPECT_LT((camera.towardsEye() - Vector3d(0, 0, 1)).norm(), 1e-12);
  EXPECT_LT((camera.up() - Vector3d(0, 1, 0)).norm(), 1e-12);
  EXPECT_LT((camera.right() - Vector3d(1, 0, 0)).norm(), 1e-12);
  for (const bool y_up : {false, true}) {
    camera.y_up = y_up;
    camera.lookFrom(Vector3d(1, -2, 3));
    EXPECT_LT((camera.towardsEye() - Vector3d(1, -2, 3).normalized()).norm(), 1e-12);
    EXPECT_GT(camera.up()[y_up ? 1 : 2], 0);
    EXPECT_NEAR(camera.right()[y_up ? 1 : 2], 0, 1e-12);
  }
}

TEST(Camera, PixelsAndRaysAreInverse) {
  Camera camera;
  camera.target = {3, -2, 7};
  camera.azimuth = 0.7;
  camera.elevation = -0.4;
  camera.distance = 55;
  const Viewport viewport{200, 30, 640, 480};
  for (const Vector3d& point : {Vector3d(3, -2, 7), Vector3d(10, 4, 9), Vector3d(-8, -9, 0)}) {
    const auto pixel = camera.pixelOf(point, viewport);
    ASSERT_TRUE(pixel);
    const Ray ray = camera.rayThrough(*pixel, viewport);
    EXPECT_LT((point - ray.origin).cross(ray.direction).norm(), 1e-9);
    EXPECT_GT((point - ray.origin).dot(ray.direction), 0);
  }
  EXPECT_LT((*camera.pixelOf(camera.target, viewport) - Eigen::Vector2d(520, 270)).norm(), 1e-9);
  EXPECT_FALSE(camera.pixelOf(camera.eye() + camera.towardsEye(), viewport));
}

TEST(Camera, TheMatricesSayTheSameAsPixelOf) {
  Camera camera;
  camera.azimuth = 2.5;
  camera.elevation = 0.8;
  const Viewport viewport{0, 0, 800, 500};
  const Vector3d point(12, -5, 20);
  const Eigen::Vector4d clip = camera.projection(viewport.aspect(), 10, 500) * camera.view() * point.homogeneous();
  const Eigen::Vector2d pixel((clip.x() / clip.w() + 1) / 2 * 800, (1 - clip.y() / clip.w()) / 2 * 500);
  EXPECT_LT((pixel - *camera.pixelOf(point, viewport)).norm(), 1e-9);
  // Near and far come out as -1 and 1.
  for (const auto& [depth, z] : {std::pair(10.0, -1.0), std::pair(500.0, 1.0)}) {
    const Vector3d at = camera.eye() - depth * camera.towardsEye();
    const Eigen::Vector4d c = camera.projection(1, 10, 500) * camera.view() * at.homogeneous();
    EXPECT_NEAR(c.z() / c.w(), z, 1e-9);
  }
}

TEST(Camera, AFramedBallTouchesTheEdgeOfThePicture) {
  for (const Viewport viewport : {Viewport{0, 0, 900, 300}, Viewport{0, 0, 300, 900}}) {
    Camera camera;
    camera.frame({5, 6, 7}, 12, viewport);
    // The outline of a ball is a cone of half angle asin(r / d); the shorter side of the picture is as wide.
    const double seen = std::asin(12 / camera.distance);
    const double half_height = camera.opening / 2, half_width = std::atan(std::tan(half_height) * viewport.aspect());
    EXPECT_NEAR(seen, std::min(half_height, half_width), 1e-9);
  }
}

TEST(Camera, PanKeepsThePointUnderThePointer) {
  Camera camera;
  camera.azimuth = 0.3;
  const Viewport viewport{0, 0, 640, 480};
  const Vector3d held = camera.target;
  camera.pan(37, -21, viewport);
  EXPECT_LT((*camera.pixelOf(held, viewport) - Eigen::Vector2d(320 + 37, 240 - 21)).norm(), 1e-9);
}

TEST(Camera, OrbitKeepsTargetAndDistanceAndStopsAtThePoles) {
  Camera camera;
  camera.orbit(0.5, 10);
  EXPECT_NEAR(camera.elevation, kHalfTurn / 2, 1e-12);
  EXPECT_NEAR((camera.eye() - camera.target).norm(), camera.distance, 1e-9);
  camera.orbit(100 * kHalfTurn + 0.25, -20);
  EXPECT_NEAR(camera.elevation, -kHalfTurn / 2, 1e-12);
  EXPECT_LE(std::abs(camera.azimuth), kHalfTurn);
  camera.zoom(2);
  EXPECT_NEAR(camera.distance, 50, 1e-9);
  camera.zoom(1e30);
  EXPECT_GT(camera.distance, 0);
}

TEST(Camera, DepthRangeHoldsTheBall) {
  Camera camera;
  for (const double distance : {0.1, 30.0, 1000.0}) {
    camera.distance = distance;
    const auto [near, far] = camera.depthRange({4, 5, 6}, 20);
    EXPECT_GT(near, 0);
    EXPECT_GE(far, (camera.eye() - Vector3d(4, 5, 6)).dot(camera.towardsEye()) + 20);
    EXPECT_GT(far, near);
  }
}

}  // namespace
}  // namespace spheretree::view
