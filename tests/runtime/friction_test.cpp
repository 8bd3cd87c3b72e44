// SPDX-License-Identifier: Apache-2.0
// Friction, flexible objects, damping, mass of the tool. Subject: mode constrained of step.h
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "spheretree/runtime/step.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::kUpright;
using test::Random;
using test::Rig;

// A plate of 60 x 60 mm whose face is z = 0 in its own axes.
SceneDescription onPlate(SphereTree tool, double friction, const Quaternion& turn = kUpright) {
  SceneDescription d;
  d.tool = std::move(tool);
  const SphereTree plate = test::withSkin(test::boxTree({30, 30, 0}, {40, 40, 1}, 1.2), test::boxSkin({30, 30, 1}));
  d.objects.push_back({plate, {turn * Vector3d(0, 0, -1), turn}});
  d.objects[0].friction = friction;
  return d;
}

SphereTree flatFoot() {
  return test::treeOfBalls({test::ball(-2, -2, 0, 1), test::ball(2, -2, 0, 1), test::ball(-2, 2, 0, 1), test::ball(2, 2, 0, 1)});
}

// The forces of the contacts obey Coulomb's law and balance the spring.
void expectCone(const Rig& rig, const StepResult& r, double friction) {
  Vector3d sum = Vector3d::Zero();
  for (const Contact& c : contacts(*rig.workspace)) {
    EXPECT_LE(c.friction.norm(), friction * c.force * 1.01 + 1e-6);
    EXPECT_NEAR(c.friction.dot(c.normal), 0, 1e-9 + 1e-6 * c.force);
    sum += c.force * c.normal + c.friction;
  }
  EXPECT_LT((sum - r.wrench.force).norm(), 1e-3 * (1 + r.wrench.force.norm()));
}

TEST(Friction, ADragIsOfTheNormalForce) {
  for (const bool is_foot : {false, true})
    for (const double speed : {1.0, 10.0, 100.0})  // mm/s
      for (int heading = 0; heading < 8; ++heading) {
        Rig rig(onPlate(is_foot ? flatFoot() : test::oneBallTree(1), 0.3));
        const double angle = heading * M_PI / 4 + 0.1;
        const Vector3d way(std::cos(angle), std::sin(angle), 0);
        rig.toPoint({0, 0, 1.5});
        StepResult r;
        for (int n = 0; n < 10; ++n) r = rig.toPoint({0, 0, 0});  // 1 N
        const int drag_steps = static_cast<int>(3 / (speed / 1000));
        for (int n = 1; n <= drag_steps; ++n) {
          r = rig.toPoint(way * (n * speed / 1000));
          ASSERT_EQ(r.unsolved, 0u);
        }
        const double normal = r.wrench.force.z(), drag = -r.wrench.force.dot(way);
        EXPECT_NEAR(normal, 1, 0.01);
        EXPECT_NEAR(drag, 0.3 * normal, 0.003 * normal) << is_foot << ' ' << speed << ' ' << heading;
        expectCone(rig, r, 0.3);
        for (const Contact& c : contacts(*rig.workspace)) EXPECT_NEAR(c.slip.dot(way), speed, 0.02 * speed);
      }
}

TEST(Friction, HoldsOnAnInclineAndSlidesOnASteeperOne) {
  for (const bool is_foot : {false, true})
    for (const double degree : {5.0, 12.0}) {
      const Quaternion turn = rotationOf({0, degree * M_PI / 180, 0});
      Rig rig(onPlate(is_foot ? flatFoot() : test::oneBallTree(1), 0.2, turn));
      const Vector3d touch = turn * Vector3d(0, 0, 1);
      rig.toPoint(touch + Vector3d(0, 0, 0.5), turn);
      StepResult r;
      for (int n = 1; n <= 200; ++n) r = rig.toPoint(touch - Vector3d(0, 0, 0.005 * n), turn);  // straight down to 1 N
      const Configuration held = r.graphic;
      for (int n = 0; n < 60000; ++n) r = rig.toPoint(touch - Vector3d(0, 0, 1), turn);
      if (degree < 6) {
        EXPECT_LT((r.graphic.position - held.position).norm(), 1e-6);
        EXPECT_LT((held.position - touch).norm(), 1e-3);  // and it did not slide while it was pressed
      } else {
        EXPECT_GT((held.position - touch).norm(), 5e-3);
      }
      expectCone(rig, r, 0.2);
    }
}

TEST(Friction, ACircleCostsWhatItRubs) {
  Rig rig(onPlate(test::oneBallTree(1), 0.25));
  const double radius = 5, speed = 0.03;  // mm in each step
  rig.toPoint({radius, 0, 1.5});
  Configuration last;
  const auto at = [&](double turn) { return Vector3d(radius * std::cos(turn), radius * std::sin(turn), 0); };
  for (int n = 0; n < 400; ++n) last = rig.toPoint(at(n * speed / radius)).graphic;
  double work = 0, path = 0, smallest = 0;
  for (int n = 400; n < 1500; ++n) {
    const StepResult r = rig.toPoint(at(n * speed / radius));
    const Vector3d way = r.graphic.position - last.position;
    const double done = -r.wrench.force.head<2>().dot(way.head<2>());
    work += done;
    smallest = std::min(smallest, done);
    path += way.norm();
    last = r.graphic;
  }
  EXPECT_NEAR(work, 0.25 * 1.0 * path, 0.01 * 0.25 * path);
  EXPECT_GE(smallest, -1e-9);
}

TEST(Friction, ACornerHoldsTheSameFromAnyStart) {
  // Two plates at a right angle; the hand is inside both. Where friction cannot hold, the pose is that of the corner.
  SceneDescription d = onPlate(test::oneBallTree(1), 0.2);
  const Quaternion wall = rotationOf({0, M_PI / 2, 0});
  d.objects.push_back({d.objects[0].tree, {Vector3d(-1, 0, 0), wall}, 0, 0.2});
  Vector3d first = Vector3d::Zero();
  for (int start = 0; start < 5; ++start) {
    Rig rig(d);
    const double angle = 0.2 + 0.28 * start;
    rig.toPoint({4 * std::cos(angle) + 1, 0, 4 * std::sin(angle) + 1});
    StepResult r;
    for (int n = 0; n < 300; ++n) {
      const double left = std::max(0.0, 1 - n / 200.0);
      r = rig.toPoint({left * 4 * std::cos(angle) - 1, 0, left * 4 * std::sin(angle) - 1});
    }
    if (start == 0) first = r.graphic.position;
    EXPECT_LT((r.graphic.position - first).norm(), 1e-4) << start;
    EXPECT_LT((r.graphic.position - Vector3d(1, 0, 1)).norm(), 2e-3);
    expectCone(rig, r, 0.2);
  }
}

// A rod of rough leaves, wedged between a hollow of cusps and an ellipsoid at random. Friction never exceeds the law,
// and dissipates nearly all that the law requires.
TEST(Friction, RoughLeavesStayInTheConeAndOut) {
  SceneDescription d;
  d.tool = test::rodTree(40, 60, 0.6);
  d.reference_point = {0, 0, 25};
  d.objects.push_back({test::withSkin(test::oneBallTree(6.5), test::cuspedSkin(3)), {}});
  d.objects.push_back({test::ellipsoidTree({5, 5, 7}, 400, 0.7), {{11.5, 0, 0}, kUpright}});
  std::uint64_t seed = 0;
  for (const double friction : {0.1, 0.3, 0.6, 1.0}) {
    d.tool_friction = friction;
    Rig rig(d);
    Random random(++seed);
    Configuration hand{{0, 20, 0}, kUpright};
    Displacement velocity;
    double taken = 0, lawful = 0;  // power [N mm/s]
    for (int n = 0; n < 1000; ++n) {
      velocity.translation = 0.95 * velocity.translation + test::randomPoint(random, 0.05) - 0.002 * hand.position;
      velocity.rotation = 0.95 * velocity.rotation + test::randomPoint(random, 0.003);
      hand = moved(hand, velocity);
      const StepResult r = rig.toPoint(hand.position, hand.orientation);
      ASSERT_LE(r.penetration, kGapTolerance);
      for (const Contact& c : contacts(*rig.workspace)) {
        ASSERT_LE(c.friction.norm(), friction * c.force * 1.01 + 2e-6) << friction << ' ' << n;
        taken -= c.friction.dot(c.slip);
        lawful += friction * c.force * c.slip.norm();
      }
    }
    EXPECT_GT(lawful, 5e4);
    EXPECT_GT(taken, 0.85 * lawful) << friction;
  }
}

TEST(Friction, IsCarriedAlongByWhatMoves) {
  SceneDescription d = onPlate(test::oneBallTree(1), 0.5);
  d.objects[0].body = 1;
  Rig rig(d);
  rig.toPoint({0, 0, 1.5});
  for (int n = 0; n < 10; ++n) rig.toPoint({0, 0, 0});
  StepResult r;
  for (int n = 1; n <= 20; ++n) {  // 0.4 mm: less than the 0.5 that the cone allows
    ASSERT_TRUE(moveBody(1, {{0.02 * n, 0, 0}, kUpright}, *rig.workspace));
    r = rig.toPoint({0, 0, 0});
  }
  EXPECT_NEAR(r.graphic.position.x(), 0.4, 1e-3);
  for (int n = 21; n <= 100; ++n) {
    moveBody(1, {{0.02 * n, 0, 0}, kUpright}, *rig.workspace);
    r = rig.toPoint({0, 0, 0});
  }
  EXPECT_NEAR(r.wrench.force.x(), 0.5, 0.005);  // it slips under the tool
  for (const Contact& c : contacts(*rig.workspace)) EXPECT_NEAR(c.slip.x(), -20, 0.5);
}

TEST(Stiffness, IsInSeriesWithTheSpring) {
  for (const bool is_foot : {false, true}) {
    Rig rigid(onPlate(is_foot ? flatFoot() : test::oneBallTree(1), 0));
    rigid.toPoint({0, 0, 1.5});
    const double touch = rigid.toPoint({0, 0, 0.9}).graphic.position.z();  // where the rigid plate holds it
    EXPECT_NEAR(touch, 1, kGapTolerance);
    for (const double stiffness : {2.0, 5.0, 50.0}) {
      SceneDescription d = onPlate(is_foot ? flatFoot() : test::oneBallTree(1), 0);
      d.objects[0].stiffness = stiffness;
      Rig rig(d);
      rig.toPoint({0, 0, 1.5});
      StepResult r;
      for (int n = 0; n <= 400; ++n) {
        const double depth = 0.001 * n;
        r = rig.toPoint({0, 0, touch - depth});
        if (n % 40 == 0 && n > 0) {
          EXPECT_NEAR(r.wrench.force.z(), depth / (1 + 1 / stiffness), 0.01 * depth) << is_foot << ' ' << stiffness;
        }
      }
      EXPECT_EQ(r.faults, 0u);
      for (int n = 0; n < 20; ++n) r = rig.toPoint({0, 0, 1.2});
      EXPECT_EQ(r.wrench.force.norm(), 0);
    }
  }
}

TEST(Damping, OfTheStretchAndNoneInFreeSpace) {
  SceneDescription d = onPlate(test::oneBallTree(1), 0);
  d.coupling.damping = 0.001;
  d.coupling.rotation_damping = 1;
  Rig rig(d);
  StepResult r;
  for (int n = 0; n < 100; ++n) r = rig.toPoint({0.1 * n, 0, 3});
  EXPECT_EQ(r.wrench.force.norm(), 0);
  rig.toPoint({0, 0, 1});
  for (int n = 1; n <= 50; ++n) r = rig.toPoint({0, 0, 1 - 0.02 * n});  // at 20 mm/s
  EXPECT_NEAR(r.wrench.force.z(), 1 + 0.001 * 20, 0.002);
  for (int n = 0; n < 50; ++n) r = rig.toPoint({0, 0, 0});
  EXPECT_NEAR(r.wrench.force.z(), 1, 1e-3);
  // On the way out the wall never pulls.
  double smallest = 0;
  for (int n = 1; n <= 100; ++n) smallest = std::min(smallest, rig.toPoint({0, 0, 0.05 * n}).wrench.force.z());
  EXPECT_GE(smallest, -1e-6);
  for (int n = 0; n < 100; ++n) r = rig.toPoint({0, 0, 5});
  EXPECT_LT(r.wrench.force.norm(), 1e-9);
}

// x[n+1] (k + M) = (2 x[n] - x[n-1]) M, with M = m/T^2, has the solution x[0] r^n cos(n angle), r = cos(angle)
// = sqrt(M / (k + M)), for a tool that starts at rest.
TEST(Mass, SwingsOnTheSpringAsTheImplicitRuleSays) {
  for (const bool is_turn : {false, true})
    for (const double step_time : {0.001, 0.0005}) {
      SceneDescription d = onPlate(test::oneBallTree(1), 0);
      d.coupling = {1, 1000, 0, 0, 0.05, 50};
      d.step_time = step_time;
      Rig rig(d);
      const double by_mass = 0.05e-3 / (step_time * step_time), r = std::sqrt(by_mass / (1 + by_mass)), angle = std::acos(r);
      const Vector3d first(0.3, -0.2, 0.1), home(0, 0, 20);
      resetTo(is_turn ? Configuration{home, rotationOf(0.1 * first)} : Configuration{home + first, kUpright}, *rig.workspace);
      for (int n = 1; n <= 2000; ++n) {
        const StepResult result = rig.toPoint(home);
        const Vector3d x = is_turn ? Vector3d(10 * rotationVector(result.graphic.orientation)) : Vector3d(result.graphic.position - home);
        ASSERT_LT((x - first * (std::pow(r, n) * std::cos(n * angle))).norm(), 1e-9) << is_turn << ' ' << n;
        const Vector3d on_hand = is_turn ? Vector3d(result.wrench.torque / 100) : result.wrench.force;
        ASSERT_LT((on_hand - x).norm(), 1e-8);  // the hand feels only the spring
      }
    }
}

TEST(Mass, ChangesNothingOfTheForceAtRest) {
  SceneDescription d = onPlate(test::oneBallTree(1), 0);
  d.coupling.mass = 0.1;
  d.coupling.inertia = 100;
  d.coupling.damping = 0.01;
  Rig rig(d);
  rig.toPoint({0, 0, 1.5});
  StepResult r;
  for (int n = 0; n < 2000; ++n) r = rig.toPoint({0, 0, 1.5 - 0.001 * std::min(n, 1000)});
  EXPECT_NEAR(r.wrench.force.z(), 0.5, 1e-3);
  EXPECT_LT(r.wrench.force.head<2>().norm() + r.wrench.torque.norm(), 1e-9);
  ASSERT_EQ(contacts(*rig.workspace).size(), 1u);
  EXPECT_NEAR(contacts(*rig.workspace)[0].force, r.wrench.force.z(), 1e-3);
}

// The energy that the hand has put in, minus that stored in spring and mass, has been dissipated for any motion of the
// hand. A wrench that is held for a step gives at most (k + c / T) d^2 for a motion d of the hand: the leak of
// sampling.
TEST(Mass, GivesNoEnergyBeyondTheLeakOfSampling) {
  for (const double damping : {0.0, 0.002})
    for (const double friction : {0.0, 0.4}) {
      SceneDescription d = onPlate(flatFoot(), friction);
      d.coupling = {1, 1000, damping, 1000 * damping, 0.05, 50};
      Rig rig(d);
      Random random(7);
      Configuration hand{{0, 0, 2}, kUpright}, last;
      Displacement velocity;
      Wrench held;
      double taken = 0, leak = 0, stored = 0;
      bool has_touched = false;
      for (int n = 0; n < 5000; ++n) {
        velocity.translation =
            0.95 * velocity.translation + test::randomPoint(random, 0.01) - 0.002 * (hand.position - Vector3d(0, 0, 0.8));
        velocity.rotation = 0.95 * velocity.rotation + test::randomPoint(random, 0.0005) - 0.002 * rotationVector(hand.orientation);
        const Configuration before = hand;
        hand = moved(hand, velocity);
        if (n > 0) {
          const Displacement way = displacementBetween(before, hand);
          taken -= held.force.dot(way.translation) + held.torque.dot(way.rotation);
          leak += (1 + damping / 0.001) * way.translation.squaredNorm() + 1000 * (1 + damping / 0.001) * way.rotation.squaredNorm();
        }
        const StepResult r = rig.toPoint(hand.position, hand.orientation);
        const Displacement stretch = displacementBetween(hand, r.graphic),
                           motion = displacementBetween(n > 0 ? last : r.graphic, r.graphic);
        stored = 0.5 * (stretch.translation.squaredNorm() + 1000 * stretch.rotation.squaredNorm()) +
                 0.5 * 50 * (motion.translation.squaredNorm() + 1000 * motion.rotation.squaredNorm());
        held = r.wrench;
        last = r.graphic;
        has_touched = has_touched || r.active > 0;
        ASSERT_GE(taken + leak, stored - 1e-3 * (1 + taken + leak)) << n;
      }
      EXPECT_TRUE(has_touched);
      EXPECT_GT(stored, 0);
    }
}

// A tool that a body pushes continues by its inertia; one that is pushed out of an object does not.
TEST(Mass, IsNotThrownOutOfAnObject) {
  SceneDescription d = onPlate(test::oneBallTree(1), 0);
  d.coupling.mass = 0.05;
  Rig rig(d);
  rig.toPoint({0, 0, 1.5});
  StepResult r;
  for (int n = 0; n < 200; ++n) r = rig.toPoint({0, 0, 1});
  ASSERT_TRUE(moveObject(0, {{0, 0, -0.5}, kUpright}, *rig.workspace));  // by 0.5 mm through the tool
  double highest = 0;
  for (int n = 0; n < 200; ++n) highest = std::max(highest, rig.toPoint({0, 0, 1}).graphic.position.z());
  EXPECT_LT(highest, 1.501);
}

TEST(Mass, ForgetsItsSpeedWhereTheModeOfThePaperTakesOver) {
  SceneDescription d = onPlate(test::oneBallTree(1), 0);
  d.coupling = {1, 1000, 0.005, 0, 0.05, 50};
  Rig rig(d);
  for (int n = 0; n < 100; ++n) rig.toPoint({0.1 * n, 0, 5});
  const Configuration there{{10, 0, 5}, {1, 0, 0, 0}};
  step(rig.scene, there, Mode::Published, *rig.workspace);
  const StepResult r = step(rig.scene, there, Mode::Constrained, *rig.workspace);
  EXPECT_LT((r.graphic.position - there.position).norm(), 1e-12);
  EXPECT_LT(r.wrench.force.norm(), 1e-12);
}

TEST(SceneDescription, RefusesFrictionStiffnessAndDampingOutOfRange) {
  Scene scene;
  std::string fault;
  const auto refused = [&](auto change) {
    SceneDescription d = onPlate(test::oneBallTree(1), 0);
    change(d);
    fault.clear();
    return !compileScene(d, scene, fault) && !fault.empty();
  };
  EXPECT_TRUE(refused([](SceneDescription& d) { d.objects[0].friction = -0.1; }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.objects[0].friction = 3; }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.tool_friction = std::nan(""); }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.objects[0].stiffness = -1; }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.coupling.damping = -1; }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.coupling.mass = -1; }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.coupling.inertia = std::nan(""); }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.step_time = 0; }));
  EXPECT_TRUE(refused([](SceneDescription& d) { d.objects[0].body = 5000; }));
}

}  // namespace
}  // namespace spheretree::runtime
