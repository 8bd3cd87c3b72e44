// SPDX-License-Identifier: Apache-2.0
// How far the force may change in a step (F5): on a convex shape no more than the hand moves, elsewhere by little more.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "spheretree/runtime/step.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

Scene compiled(SphereTree tool, SphereTree object) {
  SceneDescription d;
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
  // A dome of radius 10 of balls of radius 2, felt with balls of radius 1: touching radius 3, hand at most 1.5 below. 5 to 100 mm/s.
  constexpr double kTouch = 3, kDeepest = kTouch / 2;
  const SphereTree dome = test::ellipsoidTree({10, 10, 10}, 600, 2);
  for (const bool is_rod : {false, true}) {
    const Scene scene = compiled(is_rod ? test::rodTree(20, 40, 1) : test::oneBallTree(1), dome);
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
          worst = std::max(worst, ratio(scene.coupling, last, now, displacementBetween(before, hand)));
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

TEST(ForceStep, IsSpreadWhereTheNearestPoseJumps) {
  // The hand is 3 mm below a plate of balls and moves out past its edge: the graphic tool, above, has to come round it.
  const Scene scene = compiled(test::oneBallTree(1), test::boxTree({10, 10, 0}, {32, 32, 1}, 0.6));
  for (const Mode mode : {Mode::Constrained, Mode::Paper}) {
    Workspace workspace(scene);
    StepResult last = step(scene, {{7, 0, 3}, {1, 0, 0, 0}}, mode, workspace);
    double worst = 0;  // change of force beyond the hand's motion, over what may pass
    const auto to = [&](const Eigen::Vector3d& position) {
      const double motion = (position - workspace.haptic.position).norm();
      const StepResult now = step(scene, {position, {1, 0, 0, 0}}, mode, workspace);
      worst = std::max(worst, ((now.wrench.force - last.wrench.force).norm() - motion) / std::max(0.1, 0.07 * last.wrench.force.norm()));
      EXPECT_LE(now.penetration, kGapTolerance);
      last = now;
    };
    for (double z = 3; z > -3; z -= 0.02) to({7, 0, z});
    for (double x = 7; x < 14; x += 0.02) to({x, 0, -3});
    for (int n = 0; n < 60; ++n) to({14, 0, -3});
    EXPECT_LT(last.wrench.force.norm(), 1e-6);  // it has arrived
    if (mode == Mode::Constrained)
      EXPECT_LE(worst, 1.001);
    else
      EXPECT_GT(worst, 3);  // there is something to spread
  }
}

TEST(ForceStep, GivesNoEnergyBeyondWhatSamplingLeaks) {
  // Held for a step while the hand moves by d, a spring that only ever relaxes gives at most what it has stored and |d|^2 / 2 each step.
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
