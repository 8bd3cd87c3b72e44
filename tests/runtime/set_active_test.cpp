// SPDX-License-Identifier: Apache-2.0
// Objects that are switched off and on. Subject: setActive() of step.h
#include <gtest/gtest.h>

#include "spheretree/runtime/step.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::kUpright;
using test::Rig;

// A ball of 1 mm above a sphere of 5 mm: it touches at z = 6.
SceneDescription ballAboveSphere(bool has_skin) {
  const SphereTree body = test::oneBallTree(has_skin ? 5.2 : 5.0);
  return test::toolAndObject(test::oneBallTree(1), has_skin ? test::withSkin(body, test::roundSkin(4)) : body);
}

void settle(Rig& rig, const Vector3d& at, int steps = 100) {
  for (int n = 0; n < steps; ++n) rig.toPoint(at);
}

TEST(SetActive, AnObjectThatIsOffCostsNothingAndIsNotFelt) {
  for (const bool has_skin : {true, false})
    for (const Mode mode : {Mode::Constrained, Mode::Published}) {
      Rig rig(ballAboveSphere(has_skin));
      rig.mode = mode;
      settle(rig, {0, 0, 7});
      settle(rig, {0, 0, 5.5});
      EXPECT_GT(rig.toPoint({0, 0, 5.5}).wrench.force.z(), 0.1);
      ASSERT_TRUE(setActive(0, false, *rig.workspace));
      EXPECT_FALSE(isActive(0, *rig.workspace));
      settle(rig, {0, 0, 5.5});  // the force ends gradually in mode constrained
      for (const double z : {5.5, 3.0, 0.0, -9.0, 0.0}) {
        const StepResult r = rig.toPoint({0, 0, z});
        EXPECT_EQ(r.graphic.position.z(), z);
        EXPECT_EQ(r.wrench.force, Vector3d(0, 0, 0));
        EXPECT_EQ(r.pairs + r.rows + r.faults, 0u);
        EXPECT_LE(r.work, 8u);  // the test of eight bounding spheres, in each search
        EXPECT_TRUE(contacts(*rig.workspace).empty());
      }
    }
}

TEST(SetActive, FromAFreePoseNothingPassesThroughItAgain) {
  for (const bool has_skin : {true, false})
    for (const double speed : test::kSpeeds) {
      Rig rig(ballAboveSphere(has_skin));
      ASSERT_TRUE(setActive(0, false, *rig.workspace));
      settle(rig, {0, 0, 0}, 3);
      settle(rig, {0, 0, 30}, 3);
      ASSERT_TRUE(setActive(0, true, *rig.workspace));
      for (double z = 30; z > -20; z -= speed) {
        const StepResult r = rig.toPoint({0, 0, z});
        ASSERT_LE(r.penetration, kGapTolerance);
        ASSERT_GE(r.graphic.position.norm(), 6 - 5e-3) << speed;
      }
      settle(rig, {0.3, 0, -20}, 3);
    }
}

TEST(SetActive, SwitchedOnAroundTheToolItPushesTheToolOut) {
  for (const bool has_skin : {true, false})
    for (const Vector3d& at : {Vector3d(0.5, 0.2, 0.3), Vector3d(0, 0, 4.5), Vector3d(2, 1, 5)}) {
      Rig rig(ballAboveSphere(has_skin));
      ASSERT_TRUE(setActive(0, false, *rig.workspace));
      settle(rig, at, 3);
      ASSERT_TRUE(setActive(0, true, *rig.workspace));
      StepResult r;
      for (int n = 0; n < 100; ++n) {
        r = rig.toPoint(at);
        ASSERT_LE(r.limited_wrench.force.norm(), 8 + 1e-9);
      }
      EXPECT_LE(r.penetration, kGapTolerance) << at.transpose();
      EXPECT_NEAR(r.graphic.position.norm(), 6, has_skin ? 0.02 : 5e-3) << at.transpose();
      EXPECT_GT(r.wrench.force.norm(), 0.5);
      for (int n = 0; n < 50; ++n) r = rig.toPoint(-at.normalized() * n);  // and it is felt from outside only
      EXPECT_GE(r.graphic.position.norm(), 6 - 5e-3);
    }
}

TEST(SetActive, StaysThroughResetsAndMotions) {
  SceneDescription d = ballAboveSphere(true);
  d.objects[0].body = 1;
  d.objects.push_back({test::oneBallTree(2), {{40, 0, 0}, kUpright}, 2});
  Rig rig(std::move(d));
  settle(rig, {0, 0, 7}, 3);
  ASSERT_TRUE(setActive(0, false, *rig.workspace));
  for (const double x : {0.5, 3000.0, 0.0}) {  // near, away, and back
    ASSERT_TRUE(moveBody(1, {{x, 0, 2}, kUpright}, *rig.workspace));
    EXPECT_EQ(rig.toPoint({0, 0, 7}).graphic.position.z(), 7);  // it pushes nothing
    reset(*rig.workspace);
    EXPECT_EQ(rig.toPoint({0, 0, 7}).rows, 0u);
    ASSERT_TRUE(moveObject(0, {{x, 0, 2}, kUpright}, *rig.workspace));
    EXPECT_EQ(rig.toPoint({0, 0, 7}).rows, 0u);
  }
  EXPECT_NEAR(objectPose(0, *rig.workspace).position.z(), 2, 1e-12);
  settle(rig, {0, 0, 12}, 3);
  ASSERT_TRUE(setActive(0, true, *rig.workspace));
  settle(rig, {0, 0, 3});
  EXPECT_NEAR(rig.toPoint({0, 0, 3}).graphic.position.z(), 8, 5e-3);  // where the body has taken it
  EXPECT_FALSE(setActive(2, false, *rig.workspace));
}

TEST(SetActive, SwitchingOnAndOffGivesTheStepsOfBefore) {
  Rig rig(ballAboveSphere(true)), other(ballAboveSphere(true));
  settle(rig, {0, 0, 9}, 3), settle(other, {0, 0, 9}, 3);
  ASSERT_TRUE(setActive(0, false, *rig.workspace));
  ASSERT_TRUE(setActive(0, true, *rig.workspace));
  ASSERT_TRUE(setActive(0, true, *rig.workspace));
  for (int n = 0; n < 100; ++n) {
    const StepResult a = rig.toPoint({0.01 * n, 0, 9 - 0.1 * n}), b = other.toPoint({0.01 * n, 0, 9 - 0.1 * n});
    ASSERT_EQ(a.graphic.position, b.graphic.position) << n;
    ASSERT_EQ(a.wrench.force, b.wrench.force);
  }
}

}  // namespace
}  // namespace spheretree::runtime
