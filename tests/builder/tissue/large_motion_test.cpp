// SPDX-License-Identifier: GPL-3.0-or-later
// A block of soft tissue in large motion: steps and solver alternate. Subject: moving_tissue.h, aimTissue() of step.h
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"
#include "step/step_parts.h"
#include "support/random.h"
#include "support/shape_trees.h"
#include "support/soft_block.h"

namespace spheretree::tissue {
namespace {

using Eigen::Vector3d;
using runtime::StepResult;
const test::SoftBlock& block() { return test::fineBlock(); }

/// Like a player in lockstep: every tenth step takes the newest state, which belongs to the forces of ten steps before.
struct LargeRig {
  runtime::Scene scene;
  std::unique_ptr<runtime::Workspace> workspace;
  std::unique_ptr<MovingTissue> tissue;
  TissueState states[2];
  int steps = 0;
  bool solver_stalls = false;

  explicit LargeRig(SphereTree tool, double stiffness = 1, double friction = 0) {
    runtime::SceneDescription d;
    d.tool = std::move(tool);
    d.objects.push_back({});
    d.objects[0].tree = block().shared;
    d.objects[0].tissue = block().model;
    d.objects[0].friction = friction;
    d.coupling.translation = stiffness;
    std::string fault;
    EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
    workspace = std::make_unique<runtime::Workspace>(scene);
    tissue = MovingTissue::make(*scene.tissue(0), fault);
    EXPECT_EQ(fault, "");
    states[0] = states[1] = tissue->restState();
  }
  StepResult to(const Vector3d& p) {
    if (steps++ % 10 == 0 && !solver_stalls) {
      std::swap(states[0], states[1]);
      EXPECT_TRUE(aimTissue(0, states[0].surface, states[0].is_frozen, *workspace));
      tissue->advance(tissueForces(0, *workspace), states[1]);
    }
    return step(scene, {p, {1, 0, 0, 0}}, runtime::Mode::Constrained, *workspace);
  }
  StepResult rest(const Vector3d& p, int count = 300) {
    StepResult r;
    for (int i = 0; i < count; ++i) r = to(p);
    return r;
  }
};

TEST(LargeMotion, AtRestNothingIsDisplaced) {
  std::string fault;
  const auto tissue = MovingTissue::make(*block().tissue, fault);
  ASSERT_TRUE(tissue) << fault;
  TissueState state = tissue->restState();
  const std::vector<float> none(3 * block().tissue->response.pressed.size(), 0.0f);
  tissue->advance(none, state);
  ASSERT_EQ(state.surface.size(), none.size());
  for (const float u : state.surface) EXPECT_LT(std::abs(u), 1e-6f);
}

// At rest the steps agree with the solver's state: the forces balance the spring, and the ball is outside the moved
// surface, up to the bulge of its faces.
TEST(LargeMotion, StepsAndSolverAgreeInTheEnd) {
  for (const double stiffness : {0.1, 1.0, 10.0}) {
    LargeRig rig(test::oneBallTree(3), stiffness);
    for (double z = 16; z > 14; z -= 0.02) rig.to({12, 10, z});
    const StepResult before = rig.rest({12, 10, 14}, 500), r = rig.rest({12, 10, 14}, 33);
    EXPECT_LT((r.wrench.force - before.wrench.force).norm(), 0.03 * before.wrench.force.norm()) << stiffness;
    EXPECT_GT(r.wrench.force.z(), 0.02);
    EXPECT_EQ(r.faults, 0u);
    const std::span<const float> forces = tissueForces(0, *rig.workspace);
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 0; i < forces.size(); i += 3) sum += Vector3d(forces[i], forces[i + 1], forces[i + 2]);
    EXPECT_LT((sum + r.wrench.force).norm(), 0.02 * r.wrench.force.norm()) << "what presses is what the hand feels";
    std::vector<Vector3d> positions(block().tissue->surface.size());
    moveSurface(*block().tissue, rig.states[1].displacements, positions);
    double deepest = 0, lowest = 12;
    for (const Vector3d& p : positions) {
      deepest = std::max(deepest, 3 - (p - r.graphic.position).norm());
      if (p.z() > 9) lowest = std::min(lowest, p.z());
    }
    EXPECT_LT(deepest, 0.1) << "the ball is out of the surface";
    EXPECT_LT(lowest, 11.7) << "which has given way";
  }
}

/// Pressed in by `depth` at 10 mm/s, held, and let out again: the energy given to the hand beyond that of a spring
/// whose force is held for a step [N mm].
double energyGiven(LargeRig& rig, const Vector3d& over, double depth) {
  Vector3d last = over, force = rig.to(over).wrench.force;
  double given = 0;
  const auto go = [&](double z) {
    const Vector3d p(over.x(), over.y(), z), way = p - last;
    if (force.norm() > 0) given += force.dot(way) - 0.5 * way.squaredNorm();
    force = rig.to(p).wrench.force, last = p;
  };
  for (int i = 0; i < 100 * depth; ++i) go(last.z() - 0.01);
  for (int i = 0; i < 500; ++i) go(last.z());
  while (last.z() < over.z()) go(last.z() + 0.01);
  return given;
}

// Between two states the steps predict the solver: a rising and falling load meets the same tissue in both directions.
TEST(LargeMotion, ALoadThatGrowsAndFallsMeetsTheSameTissue) {
  for (const Vector3d& over : {Vector3d(12, 10, 15.6), Vector3d(10.4, 9.1, 15.6)})
    for (const double depth : {2.0, 4.0, 6.0}) {  // of 12 mm
      LargeRig rig(test::oneBallTree(3));
      // At ten other places at most -0.01, -0.01 and 0.07.
      EXPECT_LT(energyGiven(rig, over, depth), depth < 5 ? 0.05 : 0.1) << depth << " mm deep";
    }
}

// A solver that stops giving states: the tool becomes free at the surface at rest, not far above it.
TEST(LargeMotion, WithoutTheLoadOfTheLastStateTissueIsNearItsRest) {
  LargeRig rig(test::oneBallTree(3));
  for (double z = 16; z > 14; z -= 0.01) rig.to({12, 10, z});
  rig.rest({12, 10, 14});
  rig.solver_stalls = true;
  double free_at = 0;
  for (double z = 14; z < 18; z += 0.01)
    if (rig.to({12, 10, z}).wrench.force.norm() > 0) free_at = z;
  EXPECT_LT(free_at, 15.7);
}

TEST(LargeMotion, AToolAtAnySpeedDoesNotPassThrough) {
  for (const double speed : {0.1, 1.0, 5.0}) {  // mm in a step
    LargeRig rig(test::oneBallTree(1.5), 1, 0.3);
    StepResult r = rig.to({11, 9, 20});
    for (double z = 20; z > -20; z -= speed) {
      r = rig.to({11, 9, z});
      EXPECT_LT(r.penetration, 0.3);
      EXPECT_LE(r.limited_wrench.force.norm(), 8 + 1e-9);
    }
    for (int i = 0; i < 200; ++i) r = rig.to({11, 9, -20});
    EXPECT_GT(r.graphic.position.z(), 3) << speed;
    EXPECT_EQ(r.faults & runtime::kQpStopped, 0u);
  }
}

// A dent that a tool of many leaves made has gone when the tool comes back: it finds the surface where that is now. And
// where tissue rises to a tool that holds still, the tool is pushed up.
TEST(LargeMotion, AToolOfManyLeavesFindsTheSurfaceWhereItIs) {
  std::vector<Sphere> balls;
  for (int i = 0; i < 40; ++i) balls.push_back(test::ball(0.25 * i - 5, 0, 0, 1));
  LargeRig rig(test::treeOfBalls(balls));
  for (double z = 14; z > 9; z -= 0.02) rig.to({12, 10, z});
  rig.rest({12, 10, 9});
  rig.rest({12, 10, 40}, 600);
  StepResult r;
  for (double z = 14; z > 11; z -= 0.02) r = rig.to({12, 10, z});
  EXPECT_GT(r.wrench.force.z(), 0.2);
  r = rig.rest({12, 10, 14});
  ASSERT_LT(r.graphic.position.z(), 14.001);
  TissueState raised = rig.tissue->restState();
  for (std::size_t i = 2; i < raised.surface.size(); i += 3) raised.surface[i] += 4;
  rig.solver_stalls = true;
  EXPECT_TRUE(aimTissue(0, raised.surface, false, *rig.workspace));
  r = rig.rest({12, 10, 14});
  EXPECT_GT(r.graphic.position.z(), 14.2);
}

// Without the solver the tissue moves by its compliance at rest; when the solver is back, everything is as before.
TEST(LargeMotion, AStalledSolverIsHarmless) {
  LargeRig rig(test::oneBallTree(3));
  for (double z = 16; z > 14.5; z -= 0.02) rig.to({12, 10, z});
  const Vector3d before = rig.rest({12, 10, 14.5}).wrench.force;
  rig.solver_stalls = true;
  Vector3d last = before;
  for (int i = 0; i < 500; ++i) {
    const Vector3d force = rig.to({12, 10, 14.5 + 0.3 * std::sin(0.02 * i)}).wrench.force;
    EXPECT_LT((force - last).norm(), 0.02);
    last = force;
  }
  rig.solver_stalls = false;
  EXPECT_LT((rig.rest({12, 10, 14.5}).wrench.force - before).norm(), 0.05 * before.norm());
}

TEST(LargeMotion, AFrozenSolverSaysSo) {
  LargeRig rig(test::oneBallTree(3));
  for (double z = 16; z > 14.5; z -= 0.02) rig.to({12, 10, z});
  std::vector<float> wild(3 * block().tissue->response.pressed.size(), std::numeric_limits<float>::quiet_NaN());
  const TissueState before = rig.states[1];
  rig.tissue->advance(wild, rig.states[1]);
  EXPECT_TRUE(rig.states[1].is_frozen);
  EXPECT_EQ(rig.states[1].displacements, before.displacements);
  ASSERT_TRUE(aimTissue(0, rig.states[1].surface, true, *rig.workspace));
  const StepResult r = step(rig.scene, {{12, 10, 14.5}, {1, 0, 0, 0}}, runtime::Mode::Constrained, *rig.workspace);
  EXPECT_EQ(r.faults, runtime::kTissueFrozen);
  EXPECT_LT(r.limited_wrench.force.norm(), 8);
  EXPECT_EQ(rig.rest({12, 10, 14.5}).faults, 0u) << "and goes on";
}

TEST(LargeMotion, TheSamePathGivesTheSameBytes) {
  LargeRig one(test::oneBallTree(1.5)), other(test::oneBallTree(1.5));
  for (int i = 0; i < 300; ++i) {
    const Vector3d p(10 + 0.01 * i, 9, 13.5 - std::sin(0.02 * i));
    ASSERT_EQ(one.to(p).wrench.force, other.to(p).wrench.force);
  }
}

TEST(LargeMotion, ItIsForTissueAlone) {
  LargeRig rig(test::oneBallTree(1));
  EXPECT_FALSE(aimTissue(1, rig.states[0].surface, false, *rig.workspace));
  EXPECT_FALSE(aimTissue(0, std::span(rig.states[0].surface).first(3), false, *rig.workspace));
  EXPECT_TRUE(tissueForces(7, *rig.workspace).empty());
}

/// How deep a leaf of the tool is in the surface as it is now, by a search of its own [mm].
double depthNow(runtime::Workspace& workspace, const Configuration& tool) {
  StepResult unused;
  runtime::StepParts parts(workspace.memory(), nullptr, unused);
  const runtime::PairSet pairs = parts.search(tool, 0.05, runtime::PairsOf::ContactSurface);
  EXPECT_FALSE(pairs.coarse);
  return std::max(0.0, -static_cast<double>(parts.rows(pairs, tool).smallest_gap));
}

/// Balls of 0.1 to 0.5 mm, one above the other: the tip of a probe.
SphereTree pointedTool() {
  std::vector<Sphere> balls;
  for (int i = 0; i < 24; ++i) balls.push_back(test::ball(0, 0, 0.15 * i + 0.0055 * i * i, 0.1 + 0.02 * i));
  return test::treeOfBalls(std::move(balls));
}

// A tip is pressed in near the edge of the block, slips off over it, and leaves, while states come at any rate and
// irregularly: it is never in the surface that the step has, and nothing holds it in the end.
TEST(LargeMotion, NothingPassesThroughAtAnyRateOfStates) {
  test::Random random(54);
  for (const double friction : {0.0, 0.3})
    for (const auto& [least, most] : {std::pair{5, 20}, {33, 33}, {1, 300}, {1, 1000}}) {
      LargeRig rig(pointedTool(), 1, friction);
      rig.solver_stalls = true;  // states come here
      Vector3d hand(20.5, 10, 12.5);
      int next = 0, step = 0;
      StepResult r;
      const auto go = [&](const Vector3d& to, double speed) {
        for (Vector3d way = to - hand; way.norm() > 0; way = to - hand) {
          hand += std::min(1.0, speed / way.norm()) * way;
          if (step++ == next) {
            std::swap(rig.states[0], rig.states[1]);
            ASSERT_TRUE(aimTissue(0, rig.states[0].surface, rig.states[0].is_frozen, *rig.workspace));
            rig.tissue->advance(tissueForces(0, *rig.workspace), rig.states[1]);
            next += least + static_cast<int>(random.below(static_cast<std::uint64_t>(most - least + 1)));
          }
          r = rig.to(hand);
          const double allowed = r.faults & runtime::kWorkLimit ? 0.01 : runtime::kGapTolerance;
          ASSERT_LE(r.penetration, allowed) << least << ".." << most << " step " << step << " friction " << friction;
          ASSERT_LE(depthNow(*rig.workspace, r.graphic), allowed + 1e-5) << least << ".." << most << " step " << step;
        }
      };
      for (int round = 0; round < 2; ++round) {
        go({20.5, 10, 9}, 0.05);
        go({26, 10.5, 9}, 0.05);
        go({26, 10.5, 14}, 0.1);
        go({20.5, 10.0 - round, 14}, 0.1);
        EXPECT_EQ(r.wrench.force.norm(), 0) << "nothing holds it";
      }
    }
}

// The surface rises to a tool that has no time to give way: both stay where they were.
TEST(LargeMotion, WithoutTimeTheTissueWaits) {
  for (const std::uint32_t max_work : {1000u, 1500u, 2500u, 4000u}) {
    LargeRig rig(pointedTool());
    runtime::SceneDescription d;
    d.tool = pointedTool();
    d.objects.push_back({block().shared, {}});
    d.objects[0].tissue = block().model;
    d.step_limits.max_work = max_work;
    std::string fault;
    ASSERT_TRUE(compileScene(d, rig.scene, fault)) << fault;
    rig.workspace = std::make_unique<runtime::Workspace>(rig.scene);
    rig.solver_stalls = true;
    const Vector3d over(12, 10, 12.2);
    rig.to(over);
    TissueState raised = rig.tissue->restState();
    for (std::size_t i = 2; i < raised.surface.size(); i += 3) raised.surface[i] += 3;
    ASSERT_TRUE(aimTissue(0, raised.surface, false, *rig.workspace));
    for (int n = 0; n < 300; ++n) {
      const StepResult r = rig.to(over);
      ASSERT_LE(depthNow(*rig.workspace, r.graphic), 0.0101) << max_work << " step " << n;
    }
  }
}

}  // namespace
}  // namespace spheretree::tissue
