// SPDX-License-Identifier: Apache-2.0
// The distance of tool and object. Subject: distance() of step.h
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "spheretree/runtime/step.h"
#include "support/rig.h"
#include "support/triangle_distance.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::kUpright;
using test::Random;
using test::Rig;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

SphereTree proven(SphereTree tree, float overhang) {
  for (LevelStatistics& level : tree.statistics) level.overhang_bound = overhang;
  return tree;
}

Distance distanceOf(const Rig& rig, const Configuration& tool, double limit = kInfinite, std::size_t object = 0) {
  Distance out;
  EXPECT_TRUE(distance(object, tool, limit, *rig.workspace, out));
  return out;
}

struct World {
  const Configuration& pose;
  const SphereTree& tree;
  Vector3d operator()(const Vector3d& p) const { return pose.orientation * (p + Vector3d(tree.origin_mm.data())) + pose.position; }
};

/// The smallest gap of a leaf of the tool and a leaf, or a flat triangle, of the object.
double slowGap(const SceneDescription& d, const Configuration& tool) {
  const SphereTree& object = *d.objects[0].tree;
  const World of_object{d.objects[0].pose, object};
  double gap = kInfinite;
  for (const std::uint32_t i : levelSet(d.tool, d.tool.levelCount() - 1)) {
    const Sphere& s = d.tool.cover[i];
    const Vector3d centre = tool.orientation * (centreOf(s) + Vector3d(d.tool.origin_mm.data()) - d.reference_point) + tool.position;
    for (std::size_t t = 0; t < object.skin.triangles.size(); ++t) {
      const SkinPatch patch = patchOf(object.skin, t);
      std::array<Vector3d, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) corners[k] = of_object(patch.position[k].cast<double>());
      gap = std::min(gap, test::distanceToTriangle(centre, corners) - static_cast<double>(s.radius));
    }
    if (!object.skin.empty()) continue;
    for (const std::uint32_t j : levelSet(object, object.levelCount() - 1))
      gap = std::min(gap, (centre - of_object(centreOf(object.cover[j]))).norm() - static_cast<double>(s.radius) -
                              static_cast<double>(object.cover[j].radius));
  }
  return gap;
}

TEST(Distance, OfTwoBallsIsTheGap) {
  const Rig rig(proven(test::oneBallTree(1), 0.125f), proven(test::oneBallTree(5), 0.25f), {{10, 0, 0}, kUpright});
  const Distance d = distanceOf(rig, {{10, 0, 9}, rotationOf({1, 2, 3})});
  EXPECT_NEAR(d.lower, 3, 1e-4);
  EXPECT_LE(d.lower, 3);
  EXPECT_NEAR(d.upper, 3.375, 1e-4);
  EXPECT_GE(d.upper, 3.375);
  EXPECT_NEAR((d.on_tool - Vector3d(10, 0, 8)).norm(), 0, 1e-6);
  EXPECT_NEAR((d.on_object - Vector3d(10, 0, 5)).norm(), 0, 1e-6);
  EXPECT_NEAR(distanceOf(rig, {{10, 0, 4}, kUpright}).lower, -2, 1e-4);                                            // the leaves overlap
  EXPECT_EQ(distanceOf(Rig(test::oneBallTree(1), test::oneBallTree(5)), {{0, 0, 9}, kUpright}).upper, kInfinite);  // nothing is proven
}

TEST(Distance, IsTheSmallestOfAllPairs) {
  Random random(5);
  for (const bool has_skin : {false, true}) {
    SphereTree tree = proven(test::ellipsoidTree({6.5, 6.5, 6.5}, 300, 1.5), 0.5f);
    tree.origin_mm = {300, -20, 7};
    SceneDescription scene =
        test::toolAndObject(proven(test::rodTree(20, 40, 0.5), 0.5f), has_skin ? test::withSkin(tree, test::cuspedSkin(3)) : tree,
                            {{-200, 30, 3}, rotationOf({0.3, -1, 0.2})});
    scene.reference_point = {1, 2, 3};
    const Rig rig(std::move(scene));
    const SceneDescription& d = rig.description;
    const Vector3d middle = World{d.objects[0].pose, tree}(Vector3d::Zero());
    const double object_error = has_skin ? static_cast<double>(d.objects[0].tree->skin.mesh_distance) : 0.0,
                 object_overhang = has_skin ? object_error : 0.5;
    for (int n = 0; n < 60; ++n) {
      const Configuration tool{middle + test::randomPoint(random, 25), test::randomRotation(random)};
      const Distance found = distanceOf(rig, tool);
      const double gap = slowGap(d, tool);
      ASSERT_LE(found.lower, gap - object_error) << n;
      ASSERT_GT(found.lower, gap - object_error - 2e-3) << n;
      ASSERT_GE(found.upper, std::max(0.0, gap) + 0.5 + object_overhang) << n;
      ASSERT_LT(found.upper, std::max(0.0, gap) + 0.5 + object_overhang + 2e-3) << n;
      ASSERT_NEAR((found.on_tool - found.on_object).norm(), std::abs(gap), 1e-3) << n;
    }
  }
}

TEST(Distance, ALimitEndsTheSearch) {
  const Rig rig(test::rodTree(20, 40, 0.5), test::withSkin(test::oneBallTree(5.2), test::roundSkin(3)));
  const Configuration tool{{0, 0, 9}, kUpright};
  const Distance whole = distanceOf(rig, tool), near = distanceOf(rig, tool, 5), beyond = distanceOf(rig, tool, 2);
  EXPECT_EQ(near.lower, whole.lower);
  EXPECT_EQ(near.on_object, whole.on_object);
  EXPECT_GT(whole.lower, 2);
  EXPECT_EQ(beyond.lower, 2);
  EXPECT_EQ(beyond.upper, kInfinite);
  EXPECT_EQ(beyond.on_tool, Vector3d(0, 0, 0));
}

TEST(Distance, IsToWhereTheObjectIsNow) {
  SceneDescription d = test::toolAndObject(test::oneBallTree(1), test::oneBallTree(5));
  d.objects.push_back({test::oneBallTree(2), {{30, 0, 0}, kUpright}, 1});
  Rig rig(std::move(d));
  const Configuration tool{{0, 0, 9}, kUpright};
  rig.to(tool);
  ASSERT_TRUE(moveObject(0, {{0, 0, -4}, kUpright}, *rig.workspace));
  EXPECT_NEAR(distanceOf(rig, tool).lower, 7, 1e-4);
  // Far away, and back: bodies that are away are placed when they are needed.
  for (const double x : {5000.0, 0.0}) {
    ASSERT_TRUE(moveBody(1, {{x, 0, 9}, kUpright}, *rig.workspace));
    for (int n = 0; n < (x > 0 ? 1 : 500); ++n) rig.to(tool);  // the way back leads by the tool, in many pieces
    EXPECT_NEAR(distanceOf(rig, tool, kInfinite, 1).lower, x + 30 - 3, 0.02);
    EXPECT_NEAR(objectPose(1, *rig.workspace).position.x(), x + 30, 1e-9);
  }
  ASSERT_TRUE(setActive(0, false, *rig.workspace));
  EXPECT_NEAR(distanceOf(rig, tool).lower, 7, 1e-4);
}

TEST(Distance, RefusesWhatIsNotThere) {
  const Rig rig(test::oneBallTree(1), test::oneBallTree(5));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Distance out;
  EXPECT_FALSE(distance(1, {}, kInfinite, *rig.workspace, out));
  EXPECT_FALSE(distance(0, {{nan, 0, 0}, kUpright}, kInfinite, *rig.workspace, out));
  EXPECT_FALSE(distance(0, {}, nan, *rig.workspace, out));
}

}  // namespace
}  // namespace spheretree::runtime
