// SPDX-License-Identifier: Apache-2.0
// The QP of one piece with friction or with objects that yield; whole steps: friction_test.cpp. Subject: solveContact()
// of step_parts.h
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "step/step_parts.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::kUpright;

/// A ball of 1 mm above a ball of 100 mm, whose top is at the origin, at a gap of 0.25 mm; both springs are 1 N/mm.
struct ContactRig {
  test::Rig rig;
  StepResult result;
  StepParts parts{rig.workspace->memory(), nullptr, result};
  PairSet pairs;
  RowSet set;
  Configuration at{{0, 0, 1.25}, kUpright};

  ContactRig(double friction, double stiffness) : rig(description(friction, stiffness)) {
    pairs = parts.search(at, 5, PairsOf::ContactSurface);
    set = parts.rows(pairs, at);
  }
  static SceneDescription description(double friction, double stiffness) {
    SceneDescription d = test::toolAndObject(test::oneBallTree(1), test::oneBallTree(100), {{0, 0, -100}, kUpright});
    d.objects[0].friction = friction;
    d.objects[0].stiffness = stiffness;
    return d;
  }
  /// The step towards `translation`, and the force of the contact on the tool in it [mm of the spring].
  Vector6 stepTo(const Vector3d& translation, const CarriedPiece* carried = nullptr) {
    target = parts.scaledVector({translation, Vector3d::Zero()});
    EXPECT_EQ(parts.solveContact(pairs, set, target, at, carried), 0);
    return parts.memory.answer.y;
  }
  Vector6 target;
};

TEST(SolveContact, SlidesWithTheFrictionOfCoulomb) {
  for (const double friction : {0.1, 0.4})
    for (const Vector3d& way : {Vector3d(2, 0, -1.25), Vector3d(-1, 1.5, -0.75), Vector3d(0.5, 0.5, -1.25), Vector3d(0.05, 0, -1.25)}) {
      ContactRig r(friction, 0);
      ASSERT_EQ(r.set.rows.count, 1u);
      const Vector6 y = r.stepTo(way), pull = y - r.target;
      EXPECT_NEAR(y[2], -0.25, 1e-5) << "it arrives at the surface";
      EXPECT_NEAR(pull[2], -0.25 - way.z(), 1e-5);
      // The lowest point of the ball moves with the centre and by the rotation of an arm of 1 mm.
      const Displacement step = r.parts.displacement(y);
      const Vector3d slip = step.translation + step.rotation.cross(Vector3d(0, 0, -1)), drag(pull[0], pull[1], 0);
      const double limit = friction * pull[2];
      if (way.head<2>().norm() < limit) {
        EXPECT_LT(slip.head<2>().norm(), 1e-5) << "it sticks";
        EXPECT_LT(drag.norm(), limit);
      } else {
        EXPECT_NEAR(drag.norm(), limit, 1e-5);
        EXPECT_NEAR(drag.dot(slip), -drag.norm() * slip.head<2>().norm(), 1e-5) << "against the slip";
        EXPECT_GT(slip.head<2>().norm(), 0.05);
      }
      // The torque of the drag turns the tool: 1 mm times the drag, against 1000 N mm/rad.
      EXPECT_LT((step.rotation - Vector3d(0, 0, -1).cross(drag) / 1000).norm(), 1e-7);
      EXPECT_EQ(r.result.active, 1u);
      EXPECT_EQ(r.result.unsolved, 0u);
    }
}

TEST(SolveContact, WithoutContactNothingRubsOrYields) {
  ContactRig r(0.4, 2);
  const Vector6 y = r.stepTo({1, 1, 1});
  EXPECT_LT((y - r.target).norm(), 1e-12);
  r.parts.giveWay(1);
  EXPECT_EQ(r.parts.memory.give[0], 0);
  EXPECT_EQ(r.result.active, 0u);
}

// Springs in series: pressed in by d, the object of stiffness k yields by d / (1 + k) under the tool's 1 N/mm.
TEST(SolveContact, AnObjectThatYieldsSharesTheWayWithTheSpring) {
  for (const double stiffness : {4.0, 9.0}) {
    ContactRig r(0, stiffness);
    const Vector6 y = r.stepTo({0, 0, -1.25});
    const double give = 1 / (1 + stiffness);
    EXPECT_NEAR(y[2], -0.25 - give, 1e-5);
    EXPECT_NEAR(r.parts.memory.answer.multiplier[0], stiffness * give, 1e-5) << "the force in both springs";
    EXPECT_EQ(r.parts.memory.give[0], 0) << "until it gives way";
    r.parts.giveWay(0.5);
    EXPECT_NEAR(r.parts.memory.give[0], give / 2, 1e-5);
    r.parts.giveWay(1);
    EXPECT_NEAR(r.parts.memory.give[0], give, 1e-5);
    const RowSet later = r.parts.rows(r.pairs, r.at);
    EXPECT_NEAR(later.smallest_gap, 0.25 + give, 1e-5) << "the rows are those of the object as it yields now";
    r.parts.letGo();
    EXPECT_EQ(r.parts.memory.give[0], 0);
  }
}

// It may yield by half of the smallest distance of two centres, 101 mm.
TEST(SolveContact, AnObjectYieldsNoFartherThanItsLimit) {
  ContactRig r(0, 0.001);
  const Vector6 y = r.stepTo({0, 0, -200.25});
  r.parts.giveWay(1);
  EXPECT_NEAR(r.parts.memory.give[0], 50.5, 1e-3);
  EXPECT_NEAR(y[2], -50.75, 1e-3);
}

// A piece in which bodies move keeps the contact forces of before: with none, nothing rubs.
TEST(SolveContact, FrictionOfACarriedPieceIsThatOfBefore) {
  ContactRig r(0.4, 0);
  const CarriedPiece stays{0};
  EXPECT_LT((r.stepTo({1, 0, -1.25}, &stays) - r.parts.scaledVector({{1, 0, -0.25}, Vector3d::Zero()})).norm(), 1e-5);
  ContactRig pressed(0.4, 0);
  pressed.stepTo({0, 0, -1.25});  // a force of 1 mm of the spring
  pressed.parts.keepActive(pressed.pairs);
  const Vector6 y = pressed.stepTo({1, 0, -3.25}, &stays);
  EXPECT_NEAR(pressed.target[0] - y[0], 0.4, 1e-5) << "of the force of before, not of three times it";
  EXPECT_NEAR(y[2], -0.25, 1e-5);
  EXPECT_NEAR(pressed.parts.memory.answer.multiplier[0], 1, 1e-5) << "the next piece starts from that force, too";
}

/// Leaves bytes of this value on the stack below the caller.
[[gnu::noinline]] void fillStack(unsigned char value) {
  volatile unsigned char bytes[1 << 16];
  for (volatile unsigned char& byte : bytes) byte = value;
}

// A flat foot of 25 balls, dragged over a plate that yields and rubs. An entry that is read before it is set would have
// what is left on the stack.
TEST(SolveContact, DoesNotDependOnWhatIsOnTheStack) {
  std::vector<Vector6> first;
  for (const int value : {0, 0x3f, 0x40, 0xc1}) {
    SceneDescription d = test::toolAndObject(test::boxTree({2, 2, 0}, {5, 5, 1}, 0.7), test::boxTree({8, 8, 0}, {17, 17, 1}, 0.8));
    d.objects[0].friction = 0.3;
    d.objects[0].stiffness = 3;
    test::Rig rig(d);
    std::vector<Vector6> forces;
    for (int k = 0; k < 300; ++k) {
      const double t = 0.02 * k;
      const Quaternion turn(Eigen::AngleAxisd(0.1 * std::sin(2 * t), Vector3d(1, 2, 3).normalized()));
      fillStack(static_cast<unsigned char>(value));
      const StepResult r = rig.toPoint({2 * std::sin(t), 1.5 * std::sin(1.7 * t), 2.5 - std::min(t, 2.0)}, turn);
      forces.emplace_back();
      forces.back() << r.wrench.force, r.wrench.torque;
    }
    if (value == 0) first = forces;
    EXPECT_TRUE(forces == first) << "bytes of " << value;
  }
}

}  // namespace
}  // namespace spheretree::runtime
