// SPDX-License-Identifier: Apache-2.0
// Largest change of the force in one step (F5): on a convex shape no more than the hand's motion, elsewhere slightly
// more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "piece/force_rate_limit.h"
#include "spheretree/runtime/step.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

Scene compiled(SphereTree tool, SphereTree object, const Eigen::Vector3d& reference_point = Eigen::Vector3d::Zero()) {
  SceneDescription d;
  d.reference_point = reference_point;
  d.tool = std::move(tool);
  d.objects.push_back({std::move(object), {}});
  Scene scene;
  std::string fault;
  EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
  return scene;
}

/// |change of wrench| over |motion of the hand|, both in the metric of the stiffness.
double ratio(const Coupling& k, const StepResult& before, const StepResult& after, const Displacement& hand) {
  const double motion = std::sqrt(k.translation * hand.translation.squaredNorm() + k.rotation * hand.rotation.squaredNorm());
  const double change = std::sqrt((after.wrench.force - before.wrench.force).squaredNorm() / k.translation +
                                  (after.wrench.torque - before.wrench.torque).squaredNorm() / k.rotation);
  return motion > 1e-9 ? change / motion : 0;
}

TEST(ForceStep, IsNoLargerThanTheHandsMotionOnAConvexShape) {
  // A dome of radius 10, touched with balls of radius 1, the hand at most 1.5 below: as leaves of radius 2, which touch
  // at a distance of 3, and as a skin. 5 to 100 mm/s. A rod rattles over leaves, which are not convex, so that fast
  // force changes are spread; on the skin it slides.
  constexpr double kDeepest = 1.5;
  const SphereTree leaves = test::ellipsoidTree({10, 10, 10}, 600, 2), skin = test::withSkin(leaves, test::roundSkin(4, 10));
  for (const bool is_rod : {false, true}) {
    const Scene scene = compiled(is_rod ? test::rodTree(20, 40, 1) : test::oneBallTree(1), is_rod ? skin : leaves);
    for (const double speed : {0.005, 0.02, 0.1}) {
      Workspace workspace(scene);
      Configuration before;
      StepResult last;
      double worst = 0;
      int counted = 0;
      for (int n = 0; n < 4000; ++n) {
        const double t = speed * n, a = t / 11, b = 0.7 * a + 1, depth = kDeepest * (0.5 - 0.5 * std::cos(0.37 * t));
        Configuration hand{(11 - depth) * Eigen::Vector3d(std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b)), {1, 0, 0, 0}};
        if (is_rod) hand.orientation = rotationOf({0.4 * std::sin(1.3 * a), 0.5 * std::sin(0.7 * b), 0});
        const StepResult now = step(scene, hand, Mode::Constrained, workspace);
        const auto depthOf = [](const StepResult& r) { return r.wrench.force.norm(); };  // 1 N/mm
        if (n > 0 && std::max(depthOf(now), depthOf(last)) <= kDeepest && now.active > 0) {
          worst = std::max(worst, ratio(scene.coupling(), last, now, displacementBetween(before, hand)));
          ++counted;
        }
        before = hand;
        last = now;
      }
      EXPECT_LE(worst, 1.01) << (is_rod ? "rod" : "ball") << " at " << speed;
      EXPECT_GT(counted, 500);
    }
  }
}

// The hand is 3 mm below a plate and moves out past its edge: the graphic tool, above, has to come around it. A hand
// that also rotates changes neither the nearby contacts nor the force; held at `arm` from the ball, the jump also is
// one of the torque. Returns the changes beyond the hand's motion, over the allowed change.
struct Jumps {
  double force = 0, torque = 0;
};
Jumps jumpsPastAnEdge(const Scene& scene, Mode mode, double arm, double turn) {
  Workspace workspace(scene);
  Configuration hand{{7, 0, 3 - arm}, {1, 0, 0, 0}};
  StepResult last = step(scene, hand, mode, workspace);
  Jumps jumps;
  const auto to = [&](const Eigen::Vector3d& ball) {
    const Configuration before = hand;
    hand = {ball - Eigen::Vector3d(0, 0, arm), (rotationOf({0, 0, turn}) * hand.orientation).normalized()};
    const Displacement motion = displacementBetween(before, hand);
    const StepResult now = step(scene, hand, mode, workspace);
    const double f = (now.wrench.force - last.wrench.force).norm(), t = (now.wrench.torque - last.wrench.torque).norm();
    jumps.force = std::max(jumps.force, (f - motion.translation.norm()) / std::max(kForceStep, kForceStepPart * last.wrench.force.norm()));
    jumps.torque =
        std::max(jumps.torque, (t - 1000 * motion.rotation.norm()) / std::max(kTorqueStep, kTorqueStepPart * last.wrench.torque.norm()));
    EXPECT_LE(now.penetration, kGapTolerance);
    last = now;
  };
  for (double z = 3; z > -3; z -= 0.02) to({7, 0, z});
  for (double x = 7; x < 14; x += 0.02) to({x, 0, -3});
  for (int n = 0; n < 150; ++n) to({14, 0, -3});
  EXPECT_LT(last.wrench.force.norm(), 1e-6);  // it has arrived
  return jumps;
}

TEST(ForceStep, IsSpreadWhereTheNearestPoseJumps) {
  const SphereTree leaves = test::boxTree({10, 10, 0}, {32, 32, 1}, 0.6);
  for (const double arm : {0.0, 40.0}) {
    for (const double turn : {0.0, 0.006}) {  // in a step [rad]
      for (const bool has_skin : {false, true}) {
        const SphereTree plate = has_skin ? test::withSkin(leaves, test::boxSkin({10.4, 10.4, 0.4})) : leaves;
        const Jumps jumps = jumpsPastAnEdge(compiled(test::oneBallTree(1), plate, {0, 0, -arm}), Mode::Constrained, arm, turn);
        // A rotation may move the nearest pose, so a larger change is allowed, up to twice the perceptible one.
        EXPECT_LE(jumps.force, turn > 0 ? 2 : 1.02) << arm << ' ' << turn << ' ' << has_skin;
        EXPECT_LE(jumps.torque, turn > 0 ? 2 : 1.02) << arm << ' ' << turn << ' ' << has_skin;
      }
      const Jumps paper = jumpsPastAnEdge(compiled(test::oneBallTree(1), leaves, {0, 0, -arm}), Mode::Published, arm, turn);
      EXPECT_GT(paper.force, 6);  // the jump is large enough to be spread
    }
  }
}

TEST(ForceStep, FollowsAHandThatOnlyTurns) {
  // A ball at the end of a lever is pressed on a large ball by rotating the lever, 20 rad/s. The force changes by half
  // of the hand's motion in the metric of the springs, which is the maximum where free poses are a convex set; yet the
  // graphic tool is where it would come to rest.
  constexpr double kLever = 30;
  const Scene scene = compiled(test::oneBallTree(1), test::oneBallTree(1000), {-kLever, 0, 0});
  Workspace workspace(scene), at_rest(scene);
  double largest = 0, behind = 0;
  StepResult last;
  for (int n = 0; n < 40; ++n) {
    const Configuration hand{{-kLever, 0, 1001}, rotationOf({0, 0.02 * (n < 20 ? n : 40 - n), 0})};  // down, then up again
    const StepResult now = step(scene, hand, Mode::Constrained, workspace);
    resetTo(now.graphic, at_rest);
    StepResult rest;
    for (int k = 0; k < 200; ++k) rest = step(scene, hand, Mode::Constrained, at_rest);
    behind = std::max(behind, (rest.graphic.position - now.graphic.position).norm());
    largest = std::max(largest, (now.wrench.force - last.wrench.force).norm());
    last = now;
  }
  EXPECT_GT(largest, 0.2);  // N in a step, of a hand whose position rests
  EXPECT_LT(behind, 0.05);  // of 6 mm by which the springs are stretched: a rotation bends the space of poses slightly
}

TEST(ForceStep, GivesNoEnergyBeyondWhatSamplingLeaks) {
  // A spring whose force is held for a step while the hand moves by d gives, if it only relaxes, at most its stored
  // energy and |d|^2 / 2 in each step.
  const Scene scene = compiled(test::oneBallTree(1), test::boxTree({10, 10, 0}, {12, 12, 1}, 1.5));
  for (const double speed : {0.02, 0.2, 1.0}) {
    Workspace workspace(scene);
    test::Random random(static_cast<std::uint64_t>(100 * speed));
    Eigen::Vector3d hand(0, 0, 4), velocity = Eigen::Vector3d::Zero();
    StepResult last = step(scene, {hand, {1, 0, 0, 0}}, Mode::Constrained, workspace);
    double given = 0, leak = 0, worst = 0;
    int contacts = 0;
    for (int n = 0; n < 6000; ++n) {
      velocity =
          0.95 * velocity + test::randomPoint(random, 0.3 * speed) - 0.02 * speed * Eigen::Vector3d(hand.x(), hand.y(), hand.z() - 1) / 3;
      hand += velocity;
      given += last.wrench.force.dot(velocity);
      leak += 0.5 * velocity.squaredNorm();
      last = step(scene, {hand, {1, 0, 0, 0}}, Mode::Constrained, workspace);
      worst = std::max(worst, given + 0.5 * last.wrench.force.squaredNorm() - 1.01 * leak);
      contacts += last.active > 0;
    }
    EXPECT_LT(worst, 1e-3) << "N mm at " << speed;
    EXPECT_GT(contacts, 1000) << speed;
  }
}

}  // namespace
}  // namespace spheretree::runtime
