// SPDX-License-Identifier: Apache-2.0
// A burr cuts a block: the law of removal, the walls that are left, and that only the burr passes. Subject: step.h
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "cut/cut_layers.h"
#include "cut/cutting_resistance.h"
#include "cut/lattice_wall.h"
#include "kernel/kernel.h"
#include "spheretree/runtime/step.h"
#include "support/random.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::ball;
using test::kUpright;
using test::Random;
using test::Rig;

constexpr double kBurr = 0.5;

SharedTree block(const Vector3d& half) { return test::withSkin(test::boxTree(half, {8, 8, 4}, 1), test::boxSkin(half)); }

// A burr at the origin of the tool, and a shank above it.
SphereTree handpiece() {
  std::vector<Sphere> balls{ball(0, 0, 0, kBurr)};
  for (int k = 1; k < 8; ++k) balls.push_back(ball(0, 0, 0.5 + 0.25 * k, 0.3));
  return test::treeOfBalls(balls);
}

SceneDescription drill(const CutMaterial& material, const Vector3d& half = {6, 6, 3}) {
  SceneDescription d;
  d.tool = handpiece();
  d.burr = {{{0, 0, 0}, kBurr}};
  SceneObject object{block(half), {}};
  std::string fault;
  object.cut = cutModel(object.tree, material, fault);
  EXPECT_TRUE(object.cut) << fault;
  d.objects.push_back(object);
  return d;
}

double sumOf(const CutState& state) { return std::accumulate(state.removed.begin(), state.removed.end(), 0.0); }

// Archimedes: of a ball that has sunk by `depth` into a plane, below which it came straight down.
double drilled(double depth) {
  const double cap = std::min(depth, kBurr);
  return M_PI * cap * cap * (kBurr - cap / 3) + M_PI * kBurr * kBurr * std::max(0.0, depth - kBurr);
}

TEST(Cutting, RemovesAVolumeForEachUnitOfForceAndTime) {
  for (const double rate : {0.5, 3.0})
    for (const double stretch : {0.3, 3.0}) {
      Rig rig(drill({rate, {}, 0}));
      ASSERT_TRUE(setSpindle(true, *rig.workspace));
      Vector3d hand(0.13, 0.07, 0);
      StepResult r;
      for (double z = 5; z > 3 + kBurr; z -= 0.05) r = rig.toPoint({hand.x(), hand.y(), z});
      double impulse = 0;
      for (int n = 0; n < 4000 && r.graphic.position.z() > 2.0; ++n) {
        hand.z() = r.graphic.position.z() - stretch;
        r = rig.toPoint(hand);
        if (r.graphic.position.z() < 3 + kBurr) impulse += 0.001 * r.wrench.force.z();
        ASSERT_EQ(r.faults, 0u) << n << " z " << r.graphic.position.z() << " work " << r.work;
      }
      const double depth = 3 + kBurr - r.graphic.position.z(), exact = drilled(depth);
      EXPECT_NEAR(impulse * rate * M_PI * kBurr * kBurr / exact, 1, 0.02) << rate << " " << stretch << " " << depth;
      EXPECT_NEAR(sumOf(cutState(0, *rig.workspace)) / exact, 1, 0.02);
    }
}

// Moves down by `depth` below the surface of the block, cutting, and stays there with the spindle off.
Vector3d drillDown(Rig& rig, const Vector3d& at, double depth) {
  setSpindle(true, *rig.workspace);
  StepResult r;
  for (double z = 3 + kBurr + 1; z > 3 + kBurr - depth; z -= 0.01) r = rig.toPoint({at.x(), at.y(), z});
  for (int n = 0; n < 2000; ++n) r = rig.toPoint({at.x(), at.y(), 3 + kBurr - depth});
  setSpindle(false, *rig.workspace);
  return r.graphic.position;
}

TEST(Cutting, OnlyTheTurningBurrPasses) {
  Rig rig(drill({5, {}, 0}));
  StepResult r;
  for (double z = 5; z > 1; z -= 0.02) r = rig.toPoint({0.2, 0.1, z});  // the spindle rests
  EXPECT_NEAR(r.graphic.position.z(), 3 + kBurr, 1e-3);
  EXPECT_EQ(sumOf(cutState(0, *rig.workspace)), 0);
  setSpindle(true, *rig.workspace);
  for (int n = 0; n < 100; ++n) r = rig.toPoint({0.2, 0.1, 1});
  EXPECT_LT(r.graphic.position.z(), 3 + kBurr - 0.1);
  mend(*rig.workspace);
  EXPECT_EQ(sumOf(cutState(0, *rig.workspace)), 0);
}

// The burr rests in the hole that it has drilled, which is as wide as itself, and comes out of it the way it went in.
TEST(Cutting, TheWallOfAHoleHoldsTheBurr) {
  Rig rig(drill({8, {}, 0}));
  const Vector3d bottom = drillDown(rig, {0.33, -0.21, 0}, 1.2);
  EXPECT_NEAR(bottom.z(), 3 + kBurr - 1.2, 0.01);
  Random random(5);
  double aside = 0, below = 0, largest = 0;
  Vector3d hand = bottom, force(0, 0, 0);
  for (int n = 0; n < 4000; ++n) {
    const Vector3d to = bottom + Vector3d(random.between(-1, 1), random.between(-1, 1), random.between(-1, 0.4));
    hand += 0.02 * (to - hand);
    const StepResult r = rig.toPoint(hand);
    ASSERT_LE(r.penetration, kGapTolerance) << n;
    const Vector3d& p = r.graphic.position;
    if (p.z() < 3) {  // more than half of the burr is in the hole
      aside = std::max(aside, std::hypot(p.x() - bottom.x(), p.y() - bottom.y()));
      below = std::max(below, bottom.z() - p.z());
    }
    if (n > 0) largest = std::max(largest, (r.wrench.force - force).norm());
    force = r.wrench.force;
  }
  EXPECT_LT(aside, 0.02);
  EXPECT_LT(below, 0.01);
  EXPECT_LT(largest, 0.15);
  StepResult r;
  for (int n = 0; n < 400; ++n) r = rig.toPoint({bottom.x(), bottom.y(), bottom.z() + 0.01 * n});
  EXPECT_LT(r.wrench.force.norm(), 1e-6);
}

// A ball of 0.25 mm, 10 mm beside the burr, feels the round floor of a channel that the burr has cut.
TEST(Cutting, AChannelIsFeltAsACylinder) {
  SceneDescription d = drill({5, {}, 0});
  d.tool = test::treeOfBalls({ball(0, 0, 0, kBurr), ball(10, 0, 0, 0.25)});
  Rig rig(d);
  setSpindle(true, *rig.workspace);
  for (double z = 5; z > 3; z -= 0.01) rig.toPoint({-2, 0.03, z});
  StepResult r;
  for (double x = -2; x < 1.5; x += 0.002) r = rig.toPoint({x, 0.03 + 0.1 * x, 3});
  const Vector3d axis = r.graphic.position, along = Vector3d(1, 0.1, 0).normalized();
  setSpindle(false, *rig.workspace);
  for (double z = 3; z < 6; z += 0.01) rig.toPoint({1.5, 0.18, z});
  for (double x = 1.5; x > -10.5; x -= 0.01) rig.toPoint({x, 0.0, 6});
  std::vector<double> angles;
  Vector3d hand(-10.5, 0, 6);
  for (; hand.z() > 2.4; hand.z() -= 0.01) rig.toPoint(hand);
  for (int n = 0; n < 4000; ++n) {
    const double x = -10.5 + 0.0003 * n;
    hand = Vector3d(x, 0.03 + 0.1 * (x + 10) + 0.5 * std::sin(0.02 * n), 2.3);
    r = rig.toPoint(hand);
    Vector3d out = axis - r.graphic.position - Vector3d(10, 0, 0);
    out -= out.dot(along) * along;
    const Vector3d force = r.wrench.force - r.wrench.force.dot(along) * along;
    if (r.graphic.position.z() < 2.9 && out.norm() > 0.2) angles.push_back(test::degreesBetween(force, out));
  }
  ASSERT_GT(angles.size(), 1000u);
  std::sort(angles.begin(), angles.end());
  EXPECT_LT(angles[angles.size() / 2], 2);
  EXPECT_LT(angles[angles.size() * 99 / 100], 8);
}

// A shank is as firm in the hole as on the surface, and holds the burr that could cut on.
TEST(Cutting, TheShankDoesNotCut) {
  Rig rig(drill({8, {}, 0}));
  const Vector3d bottom = drillDown(rig, {0, 0, 0}, 2);  // the shank, of 0.3 mm, is 1.5 mm deep in a hole of 0.5 mm
  setSpindle(true, *rig.workspace);
  StepResult r;
  for (int n = 0; n < 3000; ++n) r = rig.toPoint(bottom + Vector3d(std::min(2.0, 0.001 * n), 0, 0));
  EXPECT_NEAR(r.graphic.position.x(), 0.2, 0.02);
  EXPECT_NEAR(r.wrench.force.x(), -1.8, 0.05);
}

TEST(Cutting, TheSameStepsLeaveTheSameBytes) {
  std::vector<Vector3d> places[2];
  double removed[2];
  const auto run = [&](Kernel kernel, int which) {
    Rig rig(drill({4, {}, 0.5}));
    rig.workspace = std::make_unique<Workspace>(rig.scene, kernel);
    setSpindle(true, *rig.workspace);
    Random random(7);
    Vector3d hand(0, 0, 5);
    for (int n = 0; n < 1500; ++n) {
      hand += 0.02 * (Vector3d(random.between(-1, 1), random.between(-1, 1), 2.5 + random.between(-1, 1)) - hand);
      places[which].push_back(rig.toPoint(hand).graphic.position);
    }
    removed[which] = sumOf(cutState(0, *rig.workspace));
  };
  run(Kernel::Scalar, 0);
  run(Kernel::Best, 1);
  EXPECT_EQ(places[0], places[1]);
  EXPECT_EQ(removed[0], removed[1]);
  EXPECT_GT(removed[0], 0.1);
}

// The burr is drawn through the side of the block. The spring, stretched until then, returns over several steps.
TEST(Cutting, AForceThatEndsDoesSoOverSeveralSteps) {
  Rig rig(drill({0.5, {}, 0}));
  setSpindle(true, *rig.workspace);
  for (double z = 5; z > 2.4; z -= 0.004) rig.toPoint({5.2, 0, z});
  Vector3d last = rig.toPoint({5.2, 0, 2.4}).wrench.force;
  double largest = 0, strongest = 0;
  Vector3d hand(5.2, 0, 2.4);
  for (int n = 0; n < 6000; ++n) {
    hand.x() = std::min(9.0, hand.x() + 0.002);
    const Vector3d force = rig.toPoint(hand).wrench.force;
    largest = std::max(largest, (force - last).norm());
    strongest = std::max(strongest, force.norm());
    last = force;
  }
  EXPECT_GT(strongest, 0.8);
  EXPECT_LT(last.norm(), 1e-6);
  EXPECT_LT(largest, 0.07 * strongest);
}

TEST(Cutting, ABurrIsAPartOfTheTool) {
  SceneDescription d = drill({8, {}, 0});
  d.burr = {{{0, 0, 0}, kBurr}, {{0, 0, 3}, kBurr}};
  Scene scene;
  std::string fault;
  EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
  d.burr[1].centre = {0, 0, 500};
  EXPECT_FALSE(compileScene(d, scene, fault));
  EXPECT_NE(fault.find("ball 1 of the burr is 49"), std::string::npos) << fault;
}

// The largest change of the force in a step in which the hand rests.
double largestStepAtRest(Rig& rig, const Vector3d& hand, int steps) {
  Vector3d last = rig.toPoint(hand).wrench.force;
  double largest = 0;
  for (int n = 0; n < steps; ++n) {
    const Vector3d force = rig.toPoint(hand).wrench.force;
    largest = std::max(largest, (force - last).norm());
    last = force;
  }
  EXPECT_LT(last.norm(), 1e-6);
  return largest;
}

// The hand jumps 5 mm out of a hole. The burr, which lags behind, comes to where no material is near, or its spindle
// stops on the way.
TEST(Cutting, TheForceEndsOverSeveralStepsWhereNoMaterialIsNear) {
  for (const bool stops : {false, true}) {
    Rig rig(drill({8, {}, 0}));
    const Vector3d bottom = drillDown(rig, {0.3, 0.2, 0}, 1.5);
    setSpindle(true, *rig.workspace);
    const Vector3d out = bottom + Vector3d(0.4, 0.3, 5);
    StepResult r;
    for (int n = 0; n < 30; ++n) r = rig.toPoint(out);
    ASSERT_GT(r.wrench.force.norm(), 0.5);
    if (stops) setSpindle(false, *rig.workspace);
    EXPECT_LT(largestStepAtRest(rig, out, 300), 0.2);
  }
}

// A spinning burr is tilted at its handle in the hole that it has made. It removes what its shank rests on; walls that
// are new may be a little inside the shank, or contradict each other, so that a step ends early.
TEST(Cutting, TheForceEndsOverSeveralStepsWhereTheShankComesFree) {
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Random random(seed);
    SceneDescription d = drill(CutMaterial{random.between(2, 10), {}, 0.5});
    d.reference_point = {0, 0, 15};
    Rig rig(std::move(d));
    const Vector3d start(random.between(-2, 2), random.between(-2, 2), 15);
    setSpindle(true, *rig.workspace);
    for (double z = 4; z > 1.5; z -= 0.01) rig.toPoint(start + Vector3d(0, 0, z));
    Configuration hand = rig.toPoint(start + Vector3d(0, 0, 1.5)).graphic;
    const Vector3d bottom = hand.position;
    StepResult last = rig.to(hand);
    for (int turn = 0; turn < 8; ++turn) {
      const Quaternion tilt = rotationOf(test::randomPoint(random, 0.35));
      const Vector3d to = bottom + test::randomPoint(random, 0.5);
      for (int n = 0; n < 200; ++n) {
        const Configuration before = hand;
        hand = {before.position + 0.02 * (to - before.position), before.orientation.slerp(0.02, tilt)};
        const StepResult now = rig.to(hand);
        const Displacement motion = displacementBetween(before, hand);
        const double of_hand = motion.translation.norm() + 15 * motion.rotation.norm();
        worst = std::max(worst, ((now.wrench.force - last.wrench.force).norm() - of_hand) / std::max(0.1, 0.07 * last.wrench.force.norm()));
        last = now;
      }
    }
  }
  EXPECT_LE(worst, 1);
}

// A burr that spins comes out of the hole that it has made, where nothing is left to cut.
TEST(Cutting, ABurrLeavesItsHoleWithoutResistance) {
  Rig rig(drill({3, {}, 0}));
  const Vector3d bottom = drillDown(rig, {0.3, 0.2, 0}, 1.5);
  setSpindle(true, *rig.workspace);
  const double before = sumOf(cutState(0, *rig.workspace));
  double held = 0;
  for (double z = bottom.z(); z < 5; z += 0.02) held = std::max(held, rig.toPoint({bottom.x(), bottom.y(), z}).wrench.force.norm());
  EXPECT_LT(held, 0.05);  // to cut at that speed takes 6.7 N
  EXPECT_NEAR(sumOf(cutState(0, *rig.workspace)) / before, 1, 1e-3);
}

// A leaf that covers the whole burr may reach into its shank by twice the overhang of the tree.
TEST(Cutting, ALeafThatReachesIntoTheShankIsOfTheBurr) {
  SceneDescription whole = drill({8, {}, 0}), reaching = whole;
  std::vector<Sphere> balls{ball(0, 0, 0.049, 0.553)};  // out of the mesh by less than 0.1, out of the burr by more
  for (int k = 1; k < 8; ++k) balls.push_back(ball(0, 0, 0.5 + 0.25 * k, 0.3));
  SphereTree tree = test::treeOfBalls(balls);
  for (LevelStatistics& level : tree.statistics) level.overhang_bound = 0.1f;
  reaching.tool = tree;
  Rig rig(whole), other(reaching);
  const Vector3d at(0.33, -0.21, 0);
  EXPECT_LT((drillDown(other, at, 1.2) - drillDown(rig, at, 1.2)).norm(), 1e-6);
}

TEST(Cutting, ALeafThatHoldsTheBurrAndItsShankIsRefused) {
  SceneDescription d = drill({8, {}, 0});
  std::vector<Sphere> balls{ball(0, 0, 0.5, 1.1)};
  for (int k = 3; k < 8; ++k) balls.push_back(ball(0, 0, 0.5 + 0.25 * k, 0.3));
  d.tool = test::treeOfBalls(balls);
  Scene scene;
  std::string fault;
  EXPECT_FALSE(compileScene(d, scene, fault));
  EXPECT_NE(fault.find("holds ball 0 of the burr"), std::string::npos) << fault;
}

// An edge between two triangles of the surface passes a little inside the hole: the triangle beyond it has its nearest
// point where material was removed.
TEST(Cutting, ARestingBurrIsNotCaughtByWhatItRemoved) {
  for (const double inside : {0.001, 0.003, 0.006, 0.01, 0.015, 0.02})
    for (const int side : {-1, 1}) {
      Rig rig(drill({8, {}, 0}));
      const double to_diagonal = side * (kBurr - inside) / std::sqrt(2.0);
      for (const int other : {-1, 1}) {  // either may be an edge of the block's skin
        const Vector3d at(1.7 * other + to_diagonal, 1.7 + other * -to_diagonal, 0);
        const Vector3d bottom = drillDown(rig, at, 0.8);
        StepResult r;
        for (int n = 0; n < 100; ++n) {
          r = rig.toPoint(bottom + 0.02 * n * Vector3d(-0.3 * side, 0.3 * side * other, 1));
          ASSERT_GE(r.wrench.force.z(), -0.1) << inside << " " << side << " " << other << " step " << n;
        }
        EXPECT_LT(r.wrench.force.norm(), 1e-6);
      }
    }
}

// The same block twice: each keeps what was removed of it, and only of it.
TEST(Cutting, ObjectsAreCutByThemselves) {
  SceneDescription d = drill({8, {}, 0});
  d.objects.push_back(d.objects[0]);
  d.objects[1].pose.position = {20, 0, 0};
  Rig rig(d);
  drillDown(rig, {0, 0, 0}, 0.6);
  const double first = sumOf(cutState(0, *rig.workspace));
  EXPECT_NEAR(first / drilled(0.6), 1, 0.03);
  EXPECT_EQ(sumOf(cutState(1, *rig.workspace)), 0);
  for (double z = 2.9; z < 6; z += 0.02) rig.toPoint({0, 0, z});
  for (double x = 0; x < 20; x += 0.05) rig.toPoint({x, 0, 6});
  for (double z = 6; z > 3 + kBurr - 0.6; z -= 0.01) rig.toPoint({20, 0, z});
  EXPECT_NEAR(rig.toPoint({20, 0, 3 + kBurr - 0.6}).graphic.position.z(), 3 + kBurr, 1e-3);  // the second one has no hole
  setSpindle(true, *rig.workspace);
  for (int n = 0; n < 2000; ++n) rig.toPoint({20, 0, 3 + kBurr - 0.6});
  EXPECT_EQ(sumOf(cutState(0, *rig.workspace)), first);
  EXPECT_NEAR(sumOf(cutState(1, *rig.workspace)) / first, 1, 0.03);
  mend(*rig.workspace);
  EXPECT_EQ(sumOf(cutState(0, *rig.workspace)) + sumOf(cutState(1, *rig.workspace)), 0);
}

TEST(Cutting, AToolThatComesFastIsHeldByWhatItCannotCutInAStep) {
  for (const double speed : test::kSpeeds) {
    Rig rig(drill({0.01, {}, 0}));  // hard
    setSpindle(true, *rig.workspace);
    StepResult r;
    for (double z = 20; z > -20; z -= speed) {
      r = rig.toPoint({0.4, 0.3, z});
      ASSERT_GT(r.graphic.position.z(), 3 + kBurr - 0.2) << speed;
    }
  }
}

CutFacet facetOf(const Vector3d& direction, double gap, double area, double rate) {
  CutFacet facet;
  facet.direction = direction;
  facet.along << direction, Vector3d::Zero();
  facet.gap = gap, facet.area = area, facet.rate = rate;
  return facet;
}

TEST(CutStep, TakesEnergyAndObeysTheLaw) {
  Random random(3);
  int missed = 0;  // facets on all sides, with gaps that no burr has
  for (int n = 0; n < 3000; ++n) {
    std::vector<CutFacet> facets;
    const int count = 1 + static_cast<int>(random.below(60));
    for (int k = 0; k < count; ++k)
      facets.push_back(
          facetOf(random.direction(), random.below(2) ? 0 : random.between(0, 0.1), random.between(0, 0.02), random.between(0.1, 5)));
    Vector6 target;
    target << random.between(0, 2) * random.direction(), random.direction();
    const CutStep step = cutStep(facets, target, {}, 1, 0.001);
    const Vector3d way = step.y.head<3>();
    EXPECT_LE(step.force.dot(way), 1e-12);
    EXPECT_LT((target.head<3>() - way + step.force).norm(), 2e-3 * step.force.norm() + 1e-9);  // balance with a spring of 1 N/mm
    double wanted = 0;
    for (const CutFacet& facet : facets) wanted += facet.area * std::max(0.0, facet.direction.dot(way) - facet.gap) / facet.rate;
    missed += std::abs(step.force.norm() * 0.001 / wanted - 1) > 0.02;
  }
  EXPECT_LT(missed, 30);
}

using Capsule = std::pair<Vector3d, Vector3d>;  // of the burr's radius

double gapTo(const Capsule& c, const Vector3d& p) {
  const Vector3d way = c.second - c.first;
  return (p - c.first - std::clamp((p - c.first).dot(way) / way.squaredNorm(), 0.0, 1.0) * way).norm() - kBurr;
}

/// No point of the wall that the capsules leave in the block is far from its balls, and none is in one.
void expectNearTheWall(const std::vector<Capsule>& capsules, const std::vector<Sphere>& wall, Random& random) {
  std::vector<double> gaps;
  int tries = 0;
  for (; gaps.size() < 3000 && tries < 1'000'000; ++tries) {
    const auto& c = capsules[random.below(capsules.size())];
    const Vector3d along = c.second - c.first, way = along.cross(random.direction()).normalized(),
                   p = c.first + random.between(0, 1) * along + kBurr * way;
    if ((p.cwiseAbs() - Vector3d(4, 4, 2)).maxCoeff() > 0) continue;
    double nearest = 1;
    for (const auto& other : capsules) nearest = std::min(nearest, gapTo(other, p));
    if (nearest < -1e-9) continue;
    double gap = 1;
    for (const Sphere& s : wall) gap = std::min(gap, (centreOf(s) - p).norm() - double{s.radius});
    gaps.push_back(gap);
  }
  ASSERT_EQ(gaps.size(), 3000u);
  std::sort(gaps.begin(), gaps.end());
  EXPECT_GE(gaps.front(), 0.004);
  EXPECT_LT(gaps[1500], 0.01);
  EXPECT_LT(gaps.back(), 0.022);  // at crests between two passes
}

// The judge: points of the union of capsules that lie on its boundary and in the material, against the balls of the
// wall.
TEST(CutLattice, ItsBallsLieAlongTheWallAndNeverBeyondIt) {
  const CompiledSkin skin = compileSkin(test::boxSkin({4, 4, 2}), Vector3d::Zero());
  for (const Kernel kernel : {Kernel::Scalar, Kernel::Best}) {
    CutLayers layers(skin);
    const double spacing = kBurr / 8;
    CutStorage storage(4096);
    CutLattice lattice(spacing, 4 * spacing, 0, storage, kernel == Kernel::Best && avx2Kernel() ? avx2CutKernel() : scalarCutKernel());
    std::vector<Capsule> capsules;  // a raster of 0.3 mm, slightly tilted
    for (int row = 0; row < 6; ++row)
      for (int k = 0; k < 60; ++k) {
        const auto at = [&](int i) { return Vector3d(-1.02 + 0.035 * i, -0.7 + 0.3 * row + 0.001 * i, 2.1 - 0.002 * i + 0.01 * row); };
        capsules.push_back({at(k), at(k + 1)});
      }
    std::uint32_t work = 0;
    const BlockPlace low = lattice.placeOf({-2, -2, 1}), high = lattice.placeOf({2.2, 2, 3});
    BlockPlace place;
    for (place[2] = low[2]; place[2] <= high[2]; ++place[2])
      for (place[1] = low[1]; place[1] <= high[1]; ++place[1])
        for (place[0] = low[0]; place[0] <= high[0]; ++place[0]) ASSERT_TRUE(layers.make(place, lattice, work));
    std::vector<double> volume(1);
    for (const auto& [from, to] : capsules) lattice.remove(from, to, kBurr, volume);
    std::vector<Sphere> wall;
    for (CutBlock& block : storage.blocks())
      if (lattice.hasWall(block)) {
        LatticeWall(lattice).visit(block, lattice.middleOf(block.place), 100,
                                   [&](std::size_t point) { wall.push_back(LatticeWall(lattice).ball(block, point)); });
        const std::span<const Sphere> rim = LatticeWall(lattice).rimOf(block);
        wall.insert(wall.end(), rim.begin(), rim.end());
      }
    Random random(11);
    for (const Sphere& s : wall) {  // in the material, as a ball
      ASSERT_LE((centreOf(s).cwiseAbs() - Vector3d(4, 4, 2)).maxCoeff() + double{s.radius}, 1e-5);
      for (const auto& c : capsules) ASSERT_GE(gapTo(c, centreOf(s)) - double{s.radius}, -1e-5);
    }
    expectNearTheWall(capsules, wall, random);
    double volume_in = 0;
    Vector3d at;
    for (int k = 0; k < 200'000; ++k) {
      at = {random.between(-2, 2.2), random.between(-1.5, 1.6), random.between(1, 2)};
      volume_in += std::ranges::any_of(capsules, [&](const auto& c) { return gapTo(c, at) < 0; });
    }
    EXPECT_NEAR(volume[0] / (volume_in / 200'000 * 4.2 * 3.1), 1, 0.01);
  }
}

}  // namespace
}  // namespace spheretree::runtime
