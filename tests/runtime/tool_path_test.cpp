// SPDX-License-Identifier: Apache-2.0
// Subjects: tool_path.h, and the pieces of approach.h and carry_tool.h
#include "step/tool_path.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

#include "state/moving_bodies.h"
#include "step/approach.h"
#include "step/carry_tool.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::ball;
using test::kUpright;

/// A ball of 1 mm as the tool near a ball of 5 mm about the origin, after a step to `start`. The next step goes to
/// `hand`.
struct PathRig {
  test::Rig rig;
  StepResult result;
  Configuration haptic;
  StepParts parts;
  ToolPath path;

  static SceneDescription described(std::uint32_t body, StepLimits limits) {
    SceneDescription d = test::toolAndObject(test::oneBallTree(1), test::oneBallTree(5));
    d.objects[0].body = body;
    d.step_limits = limits;
    return d;
  }
  static StepMemory& startedAt(const Vector3d& start, const Vector3d& body_to, test::Rig& rig) {
    rig.toPoint(start);
    StepMemory& memory = rig.workspace->memory();
    if (memory.bodies.size() > 1) {
      EXPECT_TRUE(moveBody(1, {body_to, kUpright}, *rig.workspace));
      startMotions(memory);
    }
    return memory;
  }
  PathRig(const Vector3d& start, const Vector3d& hand, std::uint32_t body = 0, const Vector3d& body_to = Vector3d::Zero(),
          StepLimits limits = {})
      : rig(described(body, limits)), haptic{hand, kUpright}, parts(startedAt(start, body_to, rig), nullptr, result), path(parts, haptic) {}
};

/// The pieces of the step towards the haptic pose, as constrainedStep() makes them.
std::vector<Piece> piecesOf(ToolPath& path) {
  Approach approach(path);
  std::vector<Piece> all;
  do {
    if (!path.mayGoOn() || (path.margin.needsSearch() && !path.search())) break;
    all.push_back(approach.next());
  } while (!isLast(all.back().end));
  return all;
}

TEST(ToolPath, ASearchKnowsWhatTheToolCanTouch) {
  PathRig near({0, 0, 6.5}, {0, 0, 5});
  EXPECT_TRUE(near.path.margin.needsSearch());
  EXPECT_FALSE(near.path.knowsContacts());
  EXPECT_TRUE(near.path.search());
  EXPECT_TRUE(near.path.knowsContacts());
  EXPECT_EQ(near.path.pairs().pairs.size(), 1u);
  EXPECT_NEAR(near.path.rows().smallest_gap, 0.5, 1e-5);
  EXPECT_EQ(near.path.depth(), 0);
  EXPECT_TRUE(near.path.best().isKnown());
  PathRig far({0, 0, 60}, {0, 0, 59.9});
  EXPECT_TRUE(far.path.search());
  EXPECT_TRUE(far.path.isFree());
  EXPECT_FALSE(far.path.knowsContacts());
}

TEST(ToolPath, WithoutWorkItEndsAndSaysSo) {
  PathRig r({0, 0, 6.5}, {0, 0, 5});
  EXPECT_TRUE(r.path.mayGoOn());
  EXPECT_EQ(r.result.faults, 0u);
  r.result.work = r.parts.scene.step_limits.max_work;
  EXPECT_FALSE(r.path.mayGoOn());
  EXPECT_EQ(r.result.faults, std::uint32_t{kWorkLimit});
}

TEST(ToolPath, RowsPushTheToolStraightOut) {
  PathRig r({0, 0, 6.5}, {0, 0, 5});
  ASSERT_TRUE(r.path.search());
  r.path.moveTo({{0, 0, 5.995}, kUpright});
  r.path.makeRows();
  EXPECT_NEAR(r.path.depth(), 0.005, 1e-5);
  const Displacement out = r.path.pushed(0);
  EXPECT_NEAR((out.translation - Vector3d(0, 0, 0.005)).norm(), 0, 2e-5);
}

// The reference point is beside the tool, so that a rotation moves its rows, too.
TEST(ToolPath, RowsMoveWithTheirBody) {
  SceneDescription d = PathRig::described(1, {});
  d.reference_point = {4, 0, 0};
  test::Rig rig(std::move(d));
  const Configuration at{{4, 0, 6.005}, kUpright};
  resetTo(at, *rig.workspace);
  StepMemory& memory = rig.workspace->memory();
  const Displacement motion{{0.1, 0.2, 0.8}, {0, 0.005, 0.002}};
  ASSERT_TRUE(moveBody(1, {motion.translation, rotationOf(motion.rotation)}, *rig.workspace));
  startMotions(memory);
  ASSERT_TRUE(memory.bodies[1].moves);
  StepResult result;
  StepParts parts(memory, nullptr, result);
  ToolPath path(parts, at);
  ASSERT_TRUE(path.search());
  for (const double share : {0.0, 0.5, 1.0}) {
    path.makeRows();
    ASSERT_EQ(path.rows().rows.count, 1u);
    const float before = path.rows().b[0];
    path.carryRows(share);
    // The surface moves by share * 0.8 where the body has its origin, which is below the tool.
    const double way = (static_cast<double>(path.rows().b[0]) - static_cast<double>(before)) / static_cast<double>(path.rows().weight[0]);
    EXPECT_NEAR(way, share * 0.8, 2e-4) << "up to the square of the angle, times 7.2 mm / 2";
  }
  path.moveTo({{4, 0, 5.5}, kUpright});  // 0.5 mm deep
  path.makeRows();
  path.carryRows(0);
  EXPECT_EQ(path.rows().b[0], 0) << "no deeper than now";
}

TEST(ToolPath, TheBestPoseIsTheLastFreeOne) {
  PathRig r({0, 0, 6.5}, {0, 0, 5});
  ASSERT_TRUE(r.path.search());
  const Configuration free{{0, 0, 6.1}, kUpright}, deep{{0, 0, 5.9}, kUpright};
  for (const Configuration& pose : {free, deep}) {
    r.path.moveTo(pose);
    r.path.makeRows();
    r.path.record();
  }
  EXPECT_EQ(r.path.best().pose.position, free.position);
  r.path.answerNow();
  EXPECT_EQ(r.path.best().pose.position, deep.position);
}

TEST(Approach, InFreeSpaceOnePieceEndsAtTheHand) {
  PathRig r({0, 0, 60}, {0, 0, 59.9});
  const std::vector<Piece> pieces = piecesOf(r.path);
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].end, PieceEnd::AtHand);
  EXPECT_EQ(pieces[0].share, 1);
  EXPECT_EQ(r.path.now().position, r.haptic.position);
}

// Each piece begins where the last one ended, none goes deep, and the last one finds the tool at rest where the ball is
// nearest to the hand.
TEST(Approach, PiecesLeadToTheNearestPoseOnAConvexContact) {
  const Vector3d hand(0.3, 0, 5.7);
  PathRig r({0, 0, 6.02}, hand);
  Approach approach(r.path);
  Piece piece(r.path.now());
  int count = 0;
  do {
    ASSERT_TRUE(r.path.mayGoOn() && (!r.path.margin.needsSearch() || r.path.search()));
    const Configuration from = r.path.now();
    const double margin = r.path.margin.left();
    piece = approach.next();
    EXPECT_EQ(piece.from.position, from.position);
    EXPECT_LE(piece.share * piece.length, margin + 1e-12);
    EXPECT_LE(r.path.depth(), r.path.limits.depth);
    if (piece.end == PieceEnd::AtRest) {
      EXPECT_EQ(r.path.now().position, from.position) << "a tool at rest stays";
    }
    ++count;
  } while (!isLast(piece.end));
  EXPECT_EQ(piece.end, PieceEnd::AtRest);
  EXPECT_GT(count, 1);
  EXPECT_NEAR((r.path.now().position - 6 * hand.normalized()).norm(), 0, 2e-3);
}

// The hand rests, so the way to it is a jump of the nearest pose: the tool may only start on it.
TEST(Approach, WhatTheHandDoesNotExplainEndsAtTheForceLimit) {
  PathRig r({0, 0, 6}, {0.5, 0, 6.5});
  r.parts.memory.haptic = r.haptic;
  ToolPath path(r.parts, r.haptic);
  const std::vector<Piece> pieces = piecesOf(path);
  ASSERT_FALSE(pieces.empty());
  EXPECT_EQ(pieces.back().end, PieceEnd::ForceLimit);
  EXPECT_NEAR((path.now().position - path.start.position).norm(), kForceStep, 1e-6) << "at 1 N/mm";
}

TEST(CarryTool, ABodyPushesTheToolAheadOfIt) {
  PathRig r({0, 0, 6.05}, {0, 0, 5.5}, 1, {0, 0, 0.5});
  EXPECT_EQ(carryTool(r.path), PieceEnd::GoesOn);
  EXPECT_EQ(r.parts.memory.moving_count, 0u);
  EXPECT_NEAR(bodyPose(1, *r.rig.workspace).position.z(), 0.5, 1e-12);
  EXPECT_NEAR(r.path.now().position.z(), 6.5, 2 * kPathTolerance);
  EXPECT_LE(r.path.depth(), r.path.limits.depth);
}

TEST(CarryTool, TheToolGoesOnToTheHandIfNothingHoldsIt) {
  PathRig r({0, 0, 6.005}, {0, 0, 6.03}, 1, {0.02, 0, 0});
  EXPECT_EQ(carryTool(r.path), PieceEnd::AtRest);
  EXPECT_EQ(r.path.now().position, r.haptic.position);
}

TEST(CarryTool, WithoutWorkTheBodiesStopOnTheirWay) {
  PathRig r({0, 0, 6.05}, {0, 0, 5.5}, 1, {0, 0, 0.5});
  r.result.work = r.parts.scene.step_limits.max_work;
  EXPECT_EQ(carryTool(r.path), PieceEnd::Blocked);
  EXPECT_EQ(r.parts.memory.moving_count, 1u);
  EXPECT_NE(r.result.faults & kWorkLimit, 0u);
}

}  // namespace
}  // namespace spheretree::runtime
