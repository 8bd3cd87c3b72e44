// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/step.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "spheretree/core/crc64.h"
#include "support/count_allocations.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using test::kUpright;
using test::Random;
using test::Rig;
using test::toolAndObject;

// Largest overlap of leaves, every leaf against every leaf in double.
double deepestOverlap(const SceneDescription& d, const Configuration& pose) {
  double deepest = 0;
  const auto tool = test::placedLeaves(d.tool, pose, d.reference_point);
  for (const SceneObject& object : d.objects)
    for (const test::PlacedLeaf& b : test::placedLeaves(*object.tree, object.pose, Eigen::Vector3d::Zero()))
      for (const test::PlacedLeaf& a : tool) {
        const double reach = a.radius + b.radius - deepest;
        if ((a.centre - b.centre).squaredNorm() < reach * reach) deepest = a.radius + b.radius - (a.centre - b.centre).norm();
      }
  return deepest;
}

double distance(const Configuration& a, const Configuration& b) {
  const Displacement d = displacementBetween(a, b);
  return std::sqrt(d.translation.squaredNorm() + 1000 * d.rotation.squaredNorm());
}

SphereTree plate(double thickness) { return test::boxTree({10, 10, 0}, {32, 32, 1}, thickness / 2 + 0.35); }

TEST(Step, FreeSpaceIsForceFree) {
  Rig rig(toolAndObject(test::rodTree(100, 64, 1), test::oneBallTree(1)));
  for (const Mode mode : {Mode::Constrained, Mode::Published}) {
    rig.mode = mode;
    reset(*rig.workspace);
    for (int axis = 0; axis < 3; ++axis)
      for (int n = 0; n <= 720; ++n) {
        const StepResult r = rig.to({{200, 0, 0}, rotationOf(Eigen::Vector3d::Unit(axis) * (n * M_PI / 180))});
        ASSERT_LT(r.wrench.force.norm(), 1e-9);
        ASSERT_LT(r.wrench.torque.norm(), 1e-9) << "turn " << n;
        ASSERT_EQ(r.faults, 0u);
      }
  }
}

TEST(Step, ABallOnABallIsTheExactProjection) {
  // R = 3 + 2; the haptic tool at distance 4 along a direction: the graphic tool at distance 5 along the same
  // direction.
  Rig rig(toolAndObject(test::oneBallTree(2), test::oneBallTree(3)));
  Random random(1);
  for (int n = 0; n < 200; ++n) {
    const Eigen::Vector3d u = (test::randomRotation(random) * Eigen::Vector3d::UnitX()).normalized();
    const double depth = random.between(0.01, 2.5);
    rig.to({6 * u, kUpright});
    reset(*rig.workspace);
    rig.to({6 * u, kUpright});
    StepResult r;
    for (int k = 0; k < 5; ++k) r = rig.to({(5 - depth) * u, kUpright});
    EXPECT_LT((r.graphic.position - 5 * u).norm(), 1e-4);
    EXPECT_LT((r.wrench.force - depth * u).norm(), 1e-4);
    EXPECT_LT(r.wrench.torque.norm(), 1e-3);
    EXPECT_EQ(r.faults, 0u);
  }
}

TEST(Step, NeverPenetratesInRandomMotion) {
  double deepest = 0;
  int contacts = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    SceneDescription d = toolAndObject(test::rodTree(40, 100, 0.6), test::ellipsoidTree({6, 5, 8}, 500, 0.8));
    d.objects.push_back({test::ellipsoidTree({5, 5, 7}, 400, 0.7), {{11.5, 0, 0}, kUpright}});
    d.reference_point = {0, 0, 25};
    Rig rig(std::move(d));
    Configuration haptic{{0, 20, 0}, kUpright};
    Displacement velocity;
    for (int n = 0; n < 600; ++n) {
      // Moves around the objects at up to about 2 m/s and 20 rad/s.
      velocity.translation = 0.9 * velocity.translation + test::randomPoint(random, 0.4) - 0.01 * haptic.position;
      velocity.rotation = 0.9 * velocity.rotation + test::randomPoint(random, 0.004);
      haptic = moved(haptic, velocity);
      const StepResult r = rig.to(haptic);
      ASSERT_FALSE(r.faults & (kPenetrating | kRowsConflict | kQpStopped)) << "seed " << seed << " step " << n << " faults " << r.faults;
      const double overlap = deepestOverlap(rig.description, r.graphic);
      ASSERT_LT(overlap, kGapTolerance + 1e-4) << "seed " << seed << " step " << n;
      ASSERT_NEAR(overlap, r.penetration, 1e-4);
      deepest = std::max(deepest, overlap);
      contacts += r.active > 0;
    }
  }
  EXPECT_GT(contacts, 300);
  RecordProperty("deepest_mm", std::to_string(deepest));
}

TEST(Step, NeverPassesThroughAPlate) {
  for (const double thickness : {2.0, 0.5, 0.2}) {
    Rig ball(toolAndObject(test::oneBallTree(2), plate(thickness))), probe(toolAndObject(test::rodTree(30, 40, 0.6), plate(thickness)));
    Random random(static_cast<std::uint64_t>(thickness * 10));
    for (int run = 0; run < 24; ++run) {
      Rig& rig = run % 2 ? ball : probe;
      const double speed = std::array{0.05, 0.5, 2.0, 50.0}[static_cast<std::size_t>(run) / 2 % 4],
                   tilt = random.between(0, 80) * M_PI / 180, heading = random.between(0, 6.28);
      const Eigen::Vector3d way(std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), -std::cos(tilt));
      const Eigen::Vector3d target(random.between(-2, 2), random.between(-2, 2), 0);
      reset(*rig.workspace);
      const double before = 5 / std::cos(tilt), after = std::min(4.0 / std::max(std::sin(tilt), 0.2), 30.0);
      for (double s = -before; s <= after; s += speed) {
        const StepResult r = rig.to({target + way * s, kUpright});
        ASSERT_GT(r.graphic.position.z(), 0) << "thickness " << thickness << " speed " << speed << " tilt " << tilt << " run " << run;
        ASSERT_LE(r.penetration, kGapTolerance);
      }
    }
  }
}

TEST(Step, DeepPenetrationCostsNoMoreThanShallow) {
  Rig rig(toolAndObject(test::boxTree({4, 4, 4}, {8, 8, 8}, 0.8), test::boxTree({30, 30, 30}, {20, 20, 20}, 2)));
  const auto workAt = [&](double depth) {
    reset(*rig.workspace);
    std::uint32_t largest = 0;
    double z = 45;
    for (; z > 36.7 - depth; z -= 0.05) rig.to({{0.3, 0.2, z}, kUpright});
    for (int n = 0; n < 200; ++n) {
      const StepResult r = rig.to({{0.3 + 0.02 * n, 0.2, z}, kUpright});
      EXPECT_LE(r.penetration, kGapTolerance);
      EXPECT_GT(r.active, 0u);
      if (n > 20) largest = std::max(largest, r.work);
    }
    return largest;
  };
  const std::uint32_t shallow = workAt(1), deep = workAt(40);
  EXPECT_LE(deep, 1.5 * shallow) << shallow << ' ' << deep;
}

TEST(Step, ComesBackAtOnce) {
  Rig rig(toolAndObject(test::rodTree(30, 60, 0.5), test::boxTree({10, 10, 2}, {20, 20, 3}, 1)));
  for (double z = 10; z > -8; z -= 0.1) rig.to({{0, 0, z}, rotationOf({0.3, 0, 0})});
  StepResult r;
  const Configuration away{{0, 0, 15}, rotationOf({0.5, 0.2, 0})};
  for (int n = 0; n < 5; ++n) r = rig.to(away);
  EXPECT_LT(distance(r.graphic, away), 1e-6);
  EXPECT_LT(r.wrench.force.norm(), 1e-6);
}

TEST(Step, LargeTurnsArriveWithoutPenetration) {
  // The tip rests on a floor; the hand rotates at once.
  for (const double degrees : {0.5, 5.0, 30.0, 90.0})
    for (int axis = 0; axis < 2; ++axis) {
      SceneDescription d = toolAndObject(test::rodTree(100, 128, 1), test::boxTree({60, 60, 0}, {32, 32, 1}, 3));
      d.reference_point = {0, 0, 60};
      Rig rig(std::move(d));
      StepResult r;
      for (double z = 66; z > 63; z -= 0.05) r = rig.to({{0, 0, z}, kUpright});
      const Configuration turned{{0, 0, 63}, rotationOf(Eigen::Vector3d::Unit(axis) * (degrees * M_PI / 180))};
      for (int n = 0; n < 10; ++n) {
        r = rig.to(turned);
        ASSERT_LE(deepestOverlap(rig.description, r.graphic), kGapTolerance + 1e-4) << degrees << " step " << n;
      }
      const StepResult at_rest = rig.to(turned);
      EXPECT_LT(distance(r.graphic, at_rest.graphic), 0.05) << degrees << " axis " << axis;
    }
}

TEST(Step, NoAngleIsSpecial) {
  // Pitch through 90 degrees in contact: the paper's Euler angles lose rank there. The answer must be that of the same
  // scene in another rotation.
  const Quaternion elsewhere = rotationOf({0.7, -0.4, 1.1});
  SceneDescription d = toolAndObject(test::rodTree(60, 64, 1), test::boxTree({40, 0, 40}, {24, 1, 24}, 3));
  SceneDescription turned = d;
  turned.objects[0].pose.orientation = elsewhere;
  Rig a(std::move(d)), b(std::move(turned));
  for (int n = 0; n < 400; ++n) {
    const double pitch = (80 + 0.05 * n) * M_PI / 180;
    const Configuration haptic{{0, 6 - std::min(2.5, 0.02 * n), 0}, rotationOf({0, pitch, 0})};
    const StepResult r = a.to(haptic), s = b.to({elsewhere * haptic.position, elsewhere * haptic.orientation});
    ASSERT_LT((elsewhere * r.graphic.position - s.graphic.position).norm(), 0.01) << n;
    ASSERT_LT((elsewhere * r.wrench.torque - s.wrench.torque).norm(), 0.5) << n;
  }
}

TEST(Step, StartingInsideComesOut) {
  for (const double depth : {0.5, 2.0, 4.999, 5.0}) {
    Rig rig(toolAndObject(test::oneBallTree(2), test::oneBallTree(3)));
    StepResult r;
    for (int n = 0; n < 50; ++n) {
      r = rig.to({{5 - depth, 0, 0}, kUpright});
      ASSERT_TRUE(r.graphic.position.allFinite());
    }
    EXPECT_LE(r.penetration, kGapTolerance) << depth;
    EXPECT_NEAR(r.graphic.position.norm(), 5, 2e-3) << depth;
  }
}

TEST(Step, ANarrowSlotHasTheSmallestWorstViolation) {
  // Two walls of balls, too close for the ball between them: the middle has the smallest violation.
  SceneDescription d = toolAndObject(test::oneBallTree(5), test::boxTree({0, 10, 10}, {1, 24, 24}, 1));
  d.objects[0].pose.position = {-5.9, 0, 0};
  d.objects.push_back({test::boxTree({0, 10, 10}, {1, 24, 24}, 1), {{5.9, 0, 0}, kUpright}});
  Rig rig(std::move(d));
  resetTo({{0.05, 0.1, 0.1}, kUpright}, *rig.workspace);
  StepResult r;
  for (int n = 0; n < 30; ++n) r = rig.to({{0.3, 0.1, 0.1}, kUpright});
  EXPECT_TRUE(r.faults & kPenetrating);
  double smallest = 1;
  for (double x = -0.3; x <= 0.3; x += 1e-4)
    smallest = std::min(smallest, deepestOverlap(rig.description, {{x, r.graphic.position.y(), r.graphic.position.z()}, kUpright}));
  EXPECT_GT(smallest, 0.01);
  EXPECT_NEAR(r.penetration, smallest, 1e-3);
  EXPECT_TRUE(r.wrench.force.allFinite());
}

TEST(Step, ForceStepsOnAConvexShapeAreNoLargerThanTheHandsMotion) {
  // F5: |dF| in the inverse stiffness metric over |dq| in the stiffness metric, at a depth of at most half the radius.
  Rig rig(toolAndObject(test::oneBallTree(2), test::oneBallTree(3)));
  Random random(9);
  Configuration haptic{{5.2, 0, 0}, kUpright}, before = haptic;
  StepResult last = rig.to(haptic);
  double worst = 0;
  for (int n = 0; n < 4000; ++n) {
    before = haptic;
    haptic.position += test::randomPoint(random, 0.1);
    const double r = haptic.position.norm();
    haptic.position *= std::clamp(r, 2.6, 5.3) / r;
    const StepResult now = rig.to(haptic);
    const double hand = (haptic.position - before.position).norm();
    if (hand > 0.01) worst = std::max(worst, (now.wrench.force - last.wrench.force).norm() / hand);
    last = now;
  }
  EXPECT_LE(worst, 1.01);
  RecordProperty("worst_ratio", std::to_string(worst));
}

TEST(Step, TheUnitDoesNotMatter) {
  // The same scene 1000 times larger, with the rotation stiffness by the square: the same angles, lengths times 1000.
  const auto make = [](float k) {
    SceneDescription d = toolAndObject(test::rodTree(30, 64, 1), test::boxTree({20, 20, 0}, {16, 16, 1}, 2));
    const auto scaled = [&](SphereTree tree) {
      for (Sphere& s : tree.cover) s = {k * s.x, k * s.y, k * s.z, k * s.radius};
      encloseDescendants(tree);
      countLevels(tree);
      return tree;
    };
    d.tool = scaled(d.tool);
    d.objects[0].tree = scaled(*d.objects[0].tree);
    d.coupling.rotation = 1000 * static_cast<double>(k) * static_cast<double>(k);
    return d;
  };
  Rig small(make(1)), large(make(8));
  for (int n = 0; n < 100; ++n) {
    const Configuration haptic{{0.01 * n, 0, 5 - 0.05 * n}, rotationOf({0.004 * n, 0, 0})};
    const StepResult a = small.to(haptic), b = large.to({8 * haptic.position, haptic.orientation});
    ASSERT_LT((8 * a.graphic.position - b.graphic.position).norm(), 8 * 2e-3) << n;
    ASSERT_LT((64 * a.wrench.torque - b.wrench.torque).norm(), 64 * 1.0) << n;
  }
}

TEST(Step, AllocatesNothing) {
  SceneDescription d = toolAndObject(test::rodTree(40, 100, 0.6), test::ellipsoidTree({6, 5, 8}, 500, 0.8));
  d.objects.push_back({test::withSkin(test::oneBallTree(6.5), test::cuspedSkin(3)), {{9, 0, 0}, kUpright}, 1});
  Rig rig(std::move(d));
  StageTimes times;
  for (const Mode mode : {Mode::Constrained, Mode::Published}) {
    Random random(3);
    EXPECT_EQ(test::allocationsIn([&] {
                for (int n = 0; n < 300; ++n) {
                  const Configuration haptic{test::randomPoint(random, 9), rotationOf(test::randomPoint(random, 1))};
                  step(rig.scene, haptic, mode, *rig.workspace, &times);
                  EXPECT_LE(contacts(*rig.workspace).size(), kMaxContacts);
                  if (n % 3 == 0) {
                    EXPECT_TRUE(moveBody(1, {test::randomPoint(random, 1), haptic.orientation}, *rig.workspace, {{1, 0, 0}, {0, 1, 0}}));
                  }
                  if (n % 10 == 0) {
                    EXPECT_TRUE(moveObject(1, {test::randomPoint(random, 3), haptic.orientation}, *rig.workspace));
                    EXPECT_TRUE(setActive(0, n % 20 == 0, *rig.workspace));
                    Distance found;
                    EXPECT_TRUE(distance(1, haptic, 100, *rig.workspace, found));
                  }
                }
                reset(*rig.workspace);
              }),
              0);
  }
  EXPECT_EQ(test::allocationsIn([] { ::operator delete(::operator new(4)); }), 1);  // shows that the counter counts
}

TEST(Step, KernelsAndRunsGiveTheSameBytes) {
  SceneDescription d = toolAndObject(test::rodTree(40, 100, 0.6), test::ellipsoidTree({6, 5, 8}, 500, 0.8));
  Rig rig(std::move(d));
  for (const Mode mode : {Mode::Constrained, Mode::Published}) {
    Workspace first(rig.scene, Kernel::Scalar), second(rig.scene, Kernel::Best);
    Random random(4);
    Configuration haptic{{0, 0, 12}, kUpright};
    for (int n = 0; n < 500; ++n) {
      haptic = moved(haptic, {test::randomPoint(random, 0.5) - 0.03 * haptic.position, test::randomPoint(random, 0.02)});
      const StepResult a = step(rig.scene, haptic, mode, first), b = step(rig.scene, haptic, mode, second);
      ASSERT_EQ(a.graphic.position, b.graphic.position) << n;
      ASSERT_EQ(a.graphic.orientation.coeffs(), b.graphic.orientation.coeffs());
      ASSERT_EQ(a.wrench.torque, b.wrench.torque);
      ASSERT_EQ(a.work, b.work);
    }
  }
}

TEST(Step, SmallBudgetsStaySafe) {
  for (const auto& [max_pairs, max_work] : {std::pair{64u, 100000u}, {256u, 100000u}, {8192u, 1000u}, {8192u, 3000u}}) {
    SceneDescription d = toolAndObject(test::boxTree({3, 3, 3}, {8, 8, 8}, 0.6), test::boxTree({6, 6, 6}, {8, 8, 8}, 1.2));
    d.step_limits = {max_pairs, max_work};
    Rig rig(std::move(d));
    Random random(8);
    std::uint32_t faults = 0;
    Configuration haptic{{0, 0, 14}, kUpright};
    for (int n = 0; n < 400; ++n) {
      haptic = moved(haptic, {test::randomPoint(random, 0.3) - 0.01 * haptic.position, test::randomPoint(random, 0.02)});
      const StepResult r = rig.to(haptic);
      faults |= r.faults;
      ASSERT_LE(deepestOverlap(rig.description, r.graphic), kGapTolerance + 1e-4) << max_pairs << ' ' << max_work << " step " << n;
      ASSERT_TRUE(r.wrench.force.allFinite());
      ASSERT_LE(r.limited_wrench.force.norm(), 8 + 1e-9);
    }
    if (max_pairs == 64 || max_work == 1000) {
      EXPECT_TRUE(faults & (kPairsFull | kWorkLimit)) << max_pairs << ' ' << max_work;
    }
  }
}

TEST(Step, AlwaysAnswers) {
  // Random trees that overlap each other, jumps, large rotations, starts inside, small budgets: finite, limited, within
  // the budget.
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    SceneDescription d;
    d.tool = test::randomTree(random.next(), 1 + static_cast<int>(random.below(5)), 2 + static_cast<int>(random.below(7)));
    d.reference_point = test::randomPoint(random, 10);
    for (int i = 0; i < 3; ++i)
      d.objects.push_back({test::randomTree(random.next(), 1 + static_cast<int>(random.below(5)), 2 + static_cast<int>(random.below(7))),
                           {test::randomPoint(random, 10), test::randomRotation(random)}});
    d.step_limits = {static_cast<std::uint32_t>(192 + random.below(4000)), static_cast<std::uint32_t>(1000 + random.below(60000))};
    Rig rig(std::move(d));
    for (int n = 0; n < 60; ++n) {
      rig.mode = n / 20 % 2 ? Mode::Published : Mode::Constrained;
      Configuration haptic{test::randomPoint(random, n % 7 == 0 ? 1000 : 15), test::randomRotation(random)};
      if (n % 5 == 0) haptic.orientation = Quaternion(0, 1, 0, 0);
      const StepResult r = rig.to(haptic);
      ASSERT_TRUE(isFinite(r.graphic)) << seed << ' ' << n;
      ASSERT_NEAR(r.graphic.orientation.norm(), 1, 1e-9);
      ASSERT_TRUE(r.limited_wrench.force.allFinite() && r.limited_wrench.torque.allFinite());
      ASSERT_LE(r.limited_wrench.force.norm(), 8 + 1e-9);
      ASSERT_FALSE(r.faults & kBadInput);
      // The cost of one search, one set of rows and one QP with all its relaxations, which may follow the last check of
      // the budget.
      ASSERT_LT(r.work, rig.scene.stepLimits().max_work + 40 * 101 * (rig.scene.stepLimits().max_pairs / 8 + 1) / 10) << seed << ' ' << n;
    }
  }
}

// Whatever compiler and options this was compiled with.
TEST(Step, GivesTheSameBytesInEveryBuild) {
#ifdef _WIN32
  GTEST_SKIP() << "the functions of its C library differ in the last bit: docs/platforms.md";
#endif
  std::uint64_t sum = 0;
  for (const Mode mode : {Mode::Constrained, Mode::Published}) {
    Rig rig(test::rodTree(12, 7, 1.3), test::thinPlate(0.4));
    rig.mode = mode;
    for (int n = 0; n < 1000; ++n) {
      const double t = n / 1000.0, u = t * (1 - t);
      const StepResult r = rig.to({{9 * t - 3, 20 * u * u, 6 - 30 * u}, Quaternion(1, 0.8 * t, 0.3 - u, t * u).normalized()});
      const auto add = [&](const auto& vector) { sum = crc64(std::as_bytes(std::span(vector.data(), std::size_t(vector.size()))), sum); };
      add(r.graphic.position), add(r.graphic.orientation.coeffs()), add(r.wrench.force), add(r.wrench.torque);
    }
  }
  EXPECT_EQ(sum, 5422645467127177690u);
}

TEST(Step, BadPosesDecay) {
  Rig rig(toolAndObject(test::oneBallTree(2), test::oneBallTree(3)));
  rig.to({{6, 0, 0}, kUpright});
  const StepResult good = rig.to({{4, 0, 0}, kUpright});
  EXPECT_NEAR(good.wrench.force.x(), 1, 1e-3);
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  for (const Configuration& bad :
       {Configuration{{nan, 0, 0}, kUpright}, Configuration{{0, infinity, 0}, kUpright}, Configuration{{0, 0, 1e300}, kUpright},
        Configuration{{4, 0, 0}, Quaternion(0, 0, 0, 0)}, Configuration{{4, 0, 0}, Quaternion(nan, 0, 0, 1)}}) {
    const StepResult r = rig.to(bad);
    EXPECT_EQ(r.faults, kBadInput);
    EXPECT_EQ(r.graphic.position, good.graphic.position);
    EXPECT_LT(r.wrench.force.norm(), good.wrench.force.norm());
  }
  EXPECT_NEAR(rig.to({{4, 0, 0}, kUpright}).wrench.force.x(), 1, 1e-3);
}

TEST(Step, PaperModeFollowsThePrintedFormulas) {
  // One pair: the row is (d^2 - R^2) + 2 d . dx >= 0 about the last graphic pose, so the answer is a projection on a
  // known plane.
  Rig rig(toolAndObject(test::oneBallTree(2), test::oneBallTree(3)));
  rig.mode = Mode::Published;
  const Eigen::Vector3d before(5.4, 0.3, -0.2), haptic(4.2, 0.6, 0.4);
  rig.to({before, kUpright});
  const StepResult r = rig.to({haptic, kUpright});
  // (before^2 - 25) + 2 before . (x - before) = 0, nearest to haptic
  const double value = before.squaredNorm() - 25 + 2 * before.dot(haptic - before);
  ASSERT_LT(value, 0);
  const Eigen::Vector3d expected = haptic - value * 2 * before / (4 * before.squaredNorm());
  EXPECT_LT((r.graphic.position - expected).norm(), 1e-5);
  EXPECT_LT((r.wrench.force - (expected - haptic)).norm(), 1e-5);
  EXPECT_EQ(r.pairs, 1u);
}

TEST(Step, PaperModeFollowsTheHandThroughAPlate) {
  // Once the haptic tool has left the far side, no pair holds the graphic tool: it follows. In constrained mode it
  // stays.
  for (const Mode mode : {Mode::Published, Mode::Constrained}) {
    Rig rig(toolAndObject(test::oneBallTree(1), plate(0.2)));
    rig.mode = mode;
    StepResult r;
    for (double z = 5; z > -5; z -= 0.5) r = rig.to({{0, 0, z}, kUpright});
    EXPECT_EQ(r.graphic.position.z() < 0, mode == Mode::Published);
  }
}

}  // namespace
}  // namespace spheretree::runtime
