// SPDX-License-Identifier: Apache-2.0
// A tool that starts inside an object. Subject: inside.h
#include "inside.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "spheretree/runtime/step.h"
#include "step_memory.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::kUpright;
using test::Random;

// A ball of the tool on a sphere of radius 5 whose leaf, one ball, has radius 5.2: it rests at 6 on the skin, at 6.2 on
// the leaf.
Scene toolOnSphere(SphereTree tool = test::oneBallTree(1)) {
  SceneDescription d;
  d.tool = std::move(tool);
  d.objects.push_back({test::withSkin(test::oneBallTree(5.2), test::roundSkin(4)), {}});
  Scene scene;
  std::string fault;
  EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
  return scene;
}

TEST(Inside, ComesOutByTheLeavesAndThenFeelsTheSkin) {
  const Scene scene = toolOnSphere();
  Random random(1);
  for (int n = 0; n < 60; ++n) {
    Workspace workspace(scene);
    const Vector3d way = random.direction();
    const double start = n % 6 == 0 ? 5.9 : random.between(0.1, 5.5);  // across the skin, or deep below
    // The hand stays inside; the graphic tool starts there.
    StepResult r;
    for (int k = 0; k < 200; ++k) {
      r = step(scene, {start * way, kUpright}, Mode::Constrained, workspace);
      ASSERT_TRUE(r.graphic.position.allFinite());
    }
    EXPECT_LE(r.penetration, kGapTolerance) << n;
    EXPECT_TRUE(workspace.memory().feelsSkin(0)) << n;
    EXPECT_EQ(workspace.memory().leaves_felt, 0u);
    ASSERT_NEAR(r.graphic.position.norm(), 6, 2e-3) << n << " from " << start;
    ASSERT_NEAR(r.wrench.force.norm(), 6 - start, 5e-3) << n;
  }
}

TEST(Inside, TheLeavesPushOut) {
  const Scene scene = toolOnSphere();
  Workspace workspace(scene);
  EXPECT_TRUE(workspace.memory().feelsSkin(0));
  const StepResult r = step(scene, {{3, 0, 0}, kUpright}, Mode::Constrained, workspace);
  // Out at once, and from then on it touches the skin.
  EXPECT_NEAR(r.graphic.position.x(), 6.2, 0.01);
  EXPECT_TRUE(workspace.memory().feelsSkin(0));
}

TEST(Inside, AToolBetweenSkinAndLeavesIsNotPushed) {
  // Outside the skin by 0.05, inside the leaf by 0.15: this is free.
  const Scene scene = toolOnSphere();
  Workspace workspace(scene);
  const Vector3d at(0, 6.05 / std::sqrt(2), 6.05 / std::sqrt(2));
  for (int k = 0; k < 5; ++k) {
    const StepResult r = step(scene, {at, kUpright}, Mode::Constrained, workspace);
    EXPECT_EQ(r.graphic.position, at);
    EXPECT_EQ(r.penetration, 0);
    EXPECT_TRUE(workspace.memory().feelsSkin(0));
  }
}

TEST(Inside, ARodAcrossTheObjectComesOut) {
  const Scene scene = toolOnSphere(test::rodTree(20, 40, 0.5));
  Random random(3);
  for (int n = 0; n < 20; ++n) {
    Workspace workspace(scene);
    const Configuration inside{test::randomPoint(random, 4), test::randomRotation(random)};
    resetTo(inside, workspace);
    StepResult r;
    const Configuration away{{0, 0, 25}, kUpright};
    for (int k = 0; k < 300; ++k) r = step(scene, away, Mode::Constrained, workspace);
    ASSERT_LT((r.graphic.position - away.position).norm(), 1e-6) << n;
    ASSERT_TRUE(workspace.memory().feelsSkin(0)) << n;
  }
}

TEST(Inside, OnlyTheObjectThatHoldsTheToolIsFeltByItsLeaves) {
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  const SphereTree body = test::withSkin(test::oneBallTree(5.2), test::roundSkin(3));
  d.objects.push_back({body, {}});
  d.objects.push_back({body, {{10.5, 0, 0}, kUpright}});
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
  Workspace workspace(scene);
  // Inside the first object; the second one lies beyond the way out along -x.
  StepResult r;
  for (int k = 0; k < 50; ++k) r = step(scene, {{-3, 0, 0}, kUpright}, Mode::Constrained, workspace);
  EXPECT_NEAR(r.graphic.position.x(), -6, 5e-3);
  EXPECT_TRUE(workspace.memory().feelsSkin(0) && workspace.memory().feelsSkin(1));
}

TEST(Inside, AnOpenSheetHoldsFromBothSides) {
  // A sheet has no inside: a tool stays on the side on which it starts.
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  d.objects.push_back({test::withSkin(test::boxTree({4, 4, 0}, {8, 8, 1}, 0.9), test::gridSkin(6)), {{-4, -4, -1}, kUpright}});
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
  for (const double side : {1.0, -1.0}) {
    Workspace workspace(scene);
    StepResult r;
    for (int k = 0; k < 100; ++k) r = step(scene, {{0.3, 0.2, side * std::max(3 - 0.1 * k, -2.0)}, kUpright}, Mode::Constrained, workspace);
    EXPECT_NEAR(r.graphic.position.z(), side, 2e-3);
    EXPECT_NEAR(r.wrench.force.z(), 3 * side, 5e-3);
  }
}

}  // namespace
}  // namespace spheretree::runtime
