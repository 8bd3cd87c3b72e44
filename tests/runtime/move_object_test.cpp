// SPDX-License-Identifier: Apache-2.0
// Objects that are moved between steps. Subject: moveObject() of step.h
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "spheretree/runtime/step.h"
#include "support/compiled_scene.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::compiled;
using test::kUpright;
using test::Random;

SceneDescription ballOnSphere(bool has_skin = true) {
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  SphereTree body = test::oneBallTree(5.2);
  d.objects.push_back({has_skin ? test::withSkin(body, test::roundSkin(4)) : body, {}});
  return d;
}

TEST(MoveObject, GivesWhatASceneAtTheNewPoseGives) {
  Random random(1);
  for (const bool has_skin : {true, false}) {
    SceneDescription d = ballOnSphere(has_skin);
    d.tool = test::rodTree(10, 20, 0.5);
    SphereTree tree = test::ellipsoidTree({6.5, 6.5, 6.5}, 300, 1.5);
    tree.origin_mm = {300, -20, 7};
    d.objects[0].tree = has_skin ? test::withSkin(tree, test::cuspedSkin(3)) : tree;
    d.objects.push_back({test::oneBallTree(3), {{500, 0, 0}, kUpright}});
    d.objects[0].pose = {{-300, 20, -7}, kUpright};
    const Scene before = compiled(d);
    for (int n = 0; n < 10; ++n) {
      const Configuration pose{test::randomPoint(random, 300), test::randomRotation(random)};
      d.objects[0].pose = pose;
      const Scene after = compiled(d);
      Workspace was_moved(before), was_there(after);
      ASSERT_TRUE(moveObject(0, pose, was_moved));
      const Vector3d middle = pose.orientation * Vector3d(300, -20, 7) + pose.position;
      for (int k = 0; k < 60; ++k) {
        const Configuration hand{middle + Vector3d(0.01 * k, 0, 9 - 0.1 * k), rotationOf({0.01 * k, 0, 0})};
        const StepResult a = step(before, hand, Mode::Constrained, was_moved), b = step(after, hand, Mode::Constrained, was_there);
        ASSERT_EQ(a.graphic.position, b.graphic.position) << n << ' ' << k;
        ASSERT_EQ(a.graphic.orientation.coeffs(), b.graphic.orientation.coeffs());
        ASSERT_EQ(a.wrench.force, b.wrench.force);
        ASSERT_EQ(a.rows, b.rows);
      }
      EXPECT_GT(contacts(was_moved).size(), 0u);
    }
  }
}

TEST(MoveObject, PushesTheToolAhead) {
  // The sphere rises under a hand at rest, a little each step: the ball is carried on its top.
  for (const bool has_skin : {true, false}) {
    const double touch = has_skin ? 6 : 6.2;
    const Scene scene = compiled(ballOnSphere(has_skin));
    Workspace workspace(scene);
    const Configuration hand{{0, 0, 7}, kUpright};
    StepResult r = step(scene, hand, Mode::Constrained, workspace);
    double worst = 0;
    for (int n = 0; n < 200; ++n) {
      const double z = 0.02 * n;
      ASSERT_TRUE(moveObject(0, {{0, 0, z}, kUpright}, workspace));
      r = step(scene, hand, Mode::Constrained, workspace);
      ASSERT_LE(r.penetration, kGapTolerance) << n;
      worst = std::max(worst, std::abs(r.graphic.position.z() - std::max(7.0, z + touch)));
    }
    EXPECT_LT(worst, 5e-3);
    EXPECT_NEAR(r.wrench.force.z(), 0.02 * 199 + touch - 7, 5e-3);
  }
}

TEST(MoveObject, AJumpOverTheToolPushesItOut) {
  for (const Vector3d& to : {Vector3d(0.5, 0.2, 7), Vector3d(0, 0, 8), Vector3d(3, 0, 8), Vector3d(0.2, 0.1, 20)}) {
    const Scene scene = compiled(ballOnSphere());
    Workspace workspace(scene);
    const Configuration hand{{0, 0, 8}, kUpright};
    step(scene, hand, Mode::Constrained, workspace);
    ASSERT_TRUE(moveObject(0, {to, kUpright}, workspace));
    StepResult r;
    for (int n = 0; n < 100; ++n) r = step(scene, hand, Mode::Constrained, workspace);
    EXPECT_LE(r.penetration, kGapTolerance) << to.transpose();
    const double distance = (r.graphic.position - to).norm();
    if ((hand.position - to).norm() < 6) {
      EXPECT_NEAR(distance, 6, 3e-3) << to.transpose();
    } else {
      EXPECT_EQ(r.graphic.position, hand.position);
    }
  }
}

TEST(MoveObject, RefusesInvalidPoses) {
  const Scene scene = compiled(ballOnSphere());
  Workspace workspace(scene);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(moveObject(1, {}, workspace));
  EXPECT_FALSE(moveObject(0, {{nan, 0, 0}, kUpright}, workspace));
  EXPECT_FALSE(moveObject(0, {{0, 2e7, 0}, kUpright}, workspace));
  EXPECT_FALSE(moveObject(0, {{0, 0, 0}, Quaternion(0, 0, 0, 0)}, workspace));
  step(scene, {{0, 0, 7}, kUpright}, Mode::Constrained, workspace);
  StepResult r;
  for (int n = 0; n < 10; ++n) r = step(scene, {{0, 0, 5}, kUpright}, Mode::Constrained, workspace);
  EXPECT_NEAR(r.graphic.position.z(), 6, 2e-3);  // it has not moved
}

TEST(MoveObject, TheWayBackIsTheSame) {
  // Back and forth, within reach of a touch and far away: the workspace stays valid.
  const Scene scene = compiled(ballOnSphere());
  Workspace workspace(scene);
  StepResult r = step(scene, {{0, 0, 7}, kUpright}, Mode::Constrained, workspace);
  for (const double x : {1e-3, 100.0, 1e6, 0.0}) {
    ASSERT_TRUE(moveObject(0, {{x, 0, 0}, kUpright}, workspace));
    r = step(scene, {{0, 0, 7}, kUpright}, Mode::Constrained, workspace);
    EXPECT_EQ(r.active, 0u);
  }
  for (int n = 0; n < 20; ++n) r = step(scene, {{0, 0, 5}, kUpright}, Mode::Constrained, workspace);
  EXPECT_NEAR(r.graphic.position.z(), 6, 2e-3);
}

}  // namespace
}  // namespace spheretree::runtime
