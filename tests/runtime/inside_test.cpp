// SPDX-License-Identifier: Apache-2.0
// A tool that starts inside an object. Subject: inside.h
#include "step/inside.h"
#include "scene/winding_number.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "spheretree/runtime/step.h"
#include "state/step_memory.h"
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

// The solid angle of each triangle, in units of that of the sphere.
double windingOfAll(const CompiledSkin& skin, const Vector3d& point) {
  double sum = 0;
  for (const CompiledPatch& patch : skin.patch) {
    Vector3d v[3];
    for (int k = 0; k < 3; ++k) v[k] = Eigen::Map<const Eigen::Vector3f>(patch.position[k]).cast<double>() - point;
    const double a = v[0].norm(), b = v[1].norm(), c = v[2].norm();
    sum += std::atan2(v[0].dot(v[1].cross(v[2])), a * b * c + v[0].dot(v[1]) * c + v[1].dot(v[2]) * a + v[2].dot(v[0]) * b);
  }
  return sum / (2 * M_PI);
}

TEST(Inside, TheWindingNumberIsThatOfAllTriangles) {
  Random random(5);
  for (const Skin& skin : {test::roundSkin(2), test::roundSkin(5), test::boxSkin({9, 4, 2}), test::gridSkin(24)}) {
    const CompiledSkin compiled = compileSkin(skin, Vector3d::Zero());
    for (int n = 0; n < 2000; ++n) {
      const Vector3d point = test::randomPoint(random, n % 2 == 0 ? 6 : 25);
      std::uint32_t work = 0;
      ASSERT_NEAR(windingNumber(compiled, point, work), windingOfAll(compiled, point), 0.05) << point.transpose();
      ASSERT_LE(work, 1000u) << "for " << compiled.patch.size() << " triangles";
    }
  }
}

// The side is determined in the first step, after a reset, and after an object has jumped: that is work of the step.
TEST(Inside, TheWorkThatFindsTheSideIsLimited) {
  for (const bool is_connected : {true, false}) {
    SceneDescription d;
    std::vector<Sphere> balls;
    for (int i = 0; i < 512; ++i) balls.push_back(test::ball(0.5 * (i % 8), 0.5 * (i / 8 % 8), 0.5 * (i / 64), is_connected ? 0.6 : 0.2));
    d.tool = test::withSearch(test::treeOfBalls(std::move(balls)));
    d.reference_point = {2, 2, 2};
    d.step_limits.max_work = 20'000;
    const SharedTree object(test::withSkin(test::oneBallTree(11), test::roundSkin(4, 10)));
    for (int i = 0; i < 3; ++i) d.objects.push_back({object, {{3.0 * i, 0, 0}, kUpright}});
    Scene scene;
    std::string fault;
    ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
    EXPECT_EQ(scene.compiled().tool_part_count, is_connected ? 1u : 512u);
    Workspace workspace(scene);
    const auto atMost = [&](const char* when, const Vector3d& at) {
      const StepResult r = step(scene, {at, kUpright}, Mode::Constrained, workspace);
      EXPECT_LE(r.work, is_connected ? 20'000u : 20'000u + 6'000u) << when;
      EXPECT_GT(r.work, 0u);
    };
    atMost("first step", {3, 0, 0});
    EXPECT_FALSE(workspace.memory().feelsSkin(1)) << "inside";
    reset(workspace);
    atMost("after a reset", {3, 0.1, 0});
    atMost("after a jump of the hand", {-300, 0, 0});
    resetTo({{3, 0, 0}, kUpright}, workspace);
    atMost("after a reset to a pose", {3, 0, 0});
    ASSERT_TRUE(moveObject(0, {{3, 1, 0}, kUpright}, workspace));
    atMost("after a jump of an object", {3, 0, 0});
  }
}

}  // namespace
}  // namespace spheretree::runtime
