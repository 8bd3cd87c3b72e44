// SPDX-License-Identifier: Apache-2.0
// Subjects: step_parts.h and note_contacts.h. Contacts with friction or on objects that yield: solve_contact_test.cpp
#include "step/step_parts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "step/note_contacts.h"
#include "support/random.h"
#include "support/rig.h"
#include "support/row_dot.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::ball;
using test::kUpright;
using test::Random;

/// A tool among balls, and the parts of a step there.
struct PartsRig {
  test::Rig rig;
  StepResult result;
  StepParts parts{rig.workspace->memory(), nullptr, result};
  PairSet pairs;
  RowSet set;

  PartsRig(SphereTree tool, std::vector<Sphere> balls) : rig(std::move(tool), test::treeOfBalls(std::move(balls))) {}
  explicit PartsRig(SceneDescription d) : rig(std::move(d)) {}
  void makeRows(const Configuration& pose, double margin = 5) {
    pairs = parts.search(pose, margin, PairsOf::ContactSurface);
    set = parts.rows(pairs, pose);
  }
  Vector6 target(const Vector3d& translation, const Vector3d& rotation = Vector3d::Zero()) const {
    return parts.scaledVector({translation, rotation});
  }
  const QpAnswer& answer() const { return parts.memory.answer; }
};

TEST(StepParts, ScaledVectorsAreDisplacementsAndReachBoundsTheirWay) {
  PartsRig r(test::rodTree(20, 40, 1), {ball(0, 0, 0, 1)});
  Random random(1);
  for (int n = 0; n < 100; ++n) {
    const Displacement d{random.inCube(1), random.inCube(0.5)};
    const Vector6 y = r.parts.scaledVector(d);
    EXPECT_LT((r.parts.displacement(y).translation - d.translation).norm(), 1e-15);
    EXPECT_LT((r.parts.displacement(y).rotation - d.rotation).norm(), 1e-15);
    // The energies of both springs, 1 N/mm and 1000 N mm/rad, are the square of the scaled vector.
    EXPECT_NEAR(y.squaredNorm(), d.translation.squaredNorm() + 1000 * d.rotation.squaredNorm(), 1e-9);
    const Configuration pose{random.inCube(10), test::randomRotation(random)}, after = moved(pose, d);
    double farthest = 0;
    for (const test::PlacedLeaf& before : test::placedLeaves(r.rig.description.tool, pose, Vector3d::Zero())) {
      const Vector3d way =
          after.orientation * (pose.orientation.conjugate() * (before.centre - pose.position)) + after.position - before.centre;
      farthest = std::max(farthest, way.norm());
    }
    EXPECT_GE(r.parts.reach(d), farthest);
  }
}

TEST(StepParts, SolveStopsAtTheSurface) {
  PartsRig r(test::oneBallTree(1), {ball(0, 0, 0, 2)});
  r.makeRows({{0, 0, 3.5}, kUpright});
  ASSERT_EQ(r.set.rows.count, 1u);
  EXPECT_NEAR(r.set.smallest_gap, 0.5, 1e-6);
  EXPECT_EQ(r.parts.solve(r.set, r.target({0.3, 0, -2})), 0);
  EXPECT_LT((r.answer().y - r.target({0.3, 0, -0.5})).norm(), 1e-5) << "along the surface, and down by the gap";
  EXPECT_EQ(r.result.active, 1u);
  EXPECT_NEAR(r.answer().multiplier[0], 1.5, 1e-5);
  EXPECT_EQ(r.result.faults, 0u);
  EXPECT_EQ(r.parts.solve(r.set, r.target({0, 0, 2})), 0);
  EXPECT_LT((r.answer().y - r.target({0, 0, 2})).norm(), 1e-12) << "away from it";
}

// Between two balls that overlap the tool by p and q, the best place is (p + q) / 2 deep in both.
TEST(StepParts, RowsThatContradictEachOtherYieldByTheSmallestDistance) {
  for (const double q : {0.1, 0.3}) {
    PartsRig r(test::oneBallTree(1), {ball(-3, 0, 0, 2.1), ball(3, 0, 0, 2 + q)});
    r.makeRows({{0, 0, 0}, kUpright});
    ASSERT_EQ(r.set.rows.count, 2u);
    EXPECT_NEAR(r.parts.solve(r.set, r.target({0, 0.5, 0})), (0.1 + q) / 2, 1e-5);
    EXPECT_NEAR(r.answer().y[0], (0.1 - q) / 2, 1e-5);
    EXPECT_NEAR(r.answer().y[1], 0.5, 1e-5) << "across, it is free";
    EXPECT_EQ(r.result.faults, kRowsConflict);
  }
}

TEST(StepParts, StayingIsAllowedWhereItWasNot) {
  PartsRig r(test::oneBallTree(1), {ball(0, 0, 0, 2)});
  r.makeRows({{0, 0, 2.75}, kUpright});  // 0.25 mm deep
  r.parts.solve(r.set, Vector6::Zero());
  EXPECT_NEAR(r.answer().y[2], 0.25, 1e-5) << "it is pushed out";
  r.parts.allowStaying(r.set);
  r.parts.solve(r.set, r.target({0, 0, -1}));
  EXPECT_LT(r.answer().y.norm(), 1e-5);
}

TEST(StepParts, RowsAreFoundByTheirNames) {
  SceneDescription d = test::toolAndObject(test::rodTree(20, 40, 1), test::boxTree({5, 5, 5}, {5, 5, 5}, 1.5), {{0, 0, -6}, kUpright});
  d.objects.push_back({test::ellipsoidTree({4, 4, 6}, 100, 1), {{6, 0, 0}, kUpright}});
  PartsRig r(std::move(d));
  r.makeRows({{1, 0, 0}, kUpright});
  ASSERT_GT(r.pairs.pairs.size(), 20u);
  ASSERT_EQ(r.pairs.runs.size(), 2u);
  for (std::uint32_t row = 0; row < r.pairs.pairs.size(); ++row) {
    const RowName name = r.parts.nameOfRow(r.pairs, row);
    EXPECT_EQ(name.object, row < r.pairs.runs[1].begin ? 0u : 1u);
    EXPECT_EQ(name.pair, r.pairs.pairs[row]);
    EXPECT_FALSE(name.is_felt);
    EXPECT_EQ(r.parts.rowOf(r.pairs, name), row);
    EXPECT_EQ(r.parts.rowOf(r.pairs, {name.object, name.pair, true}), ~0u) << "no row of a patch";
    EXPECT_EQ(r.parts.rowOf(r.pairs, {name.object, 0xffffffff, false}), ~0u);
  }
  // The active rows keep their names when the pairs come again in other places.
  r.parts.solve(r.set, r.target({0, 0, -3}));
  r.parts.keepActive(r.pairs);
  const std::vector<RowName> names(r.parts.memory.active_names.begin(), r.parts.memory.active_names.begin() + r.parts.memory.active_count);
  ASSERT_GT(names.size(), 0u);
  r.makeRows({{1, 0, 0}, kUpright}, 1);
  r.parts.findActive(r.pairs);
  ASSERT_EQ(r.answer().active_count, names.size());
  for (std::size_t k = 0; k < names.size(); ++k) EXPECT_EQ(r.parts.nameOfRow(r.pairs, r.answer().active[k]), names[k]);
}

TEST(StepParts, CountsItsWorkAndEndsWhenItIsUsedUp) {
  SceneDescription d = test::toolAndObject(test::rodTree(20, 40, 1), test::boxTree({5, 5, 5}, {10, 10, 10}, 1.5));
  d.step_limits.max_work = 1000;
  PartsRig r(std::move(d));
  EXPECT_TRUE(r.parts.workLeft());
  r.makeRows({{0, 0, 0}, kUpright}, 0.1);
  EXPECT_EQ(r.result.searches, 1u);
  EXPECT_EQ(r.result.linearisations, 1u);
  EXPECT_EQ(r.result.pairs, r.pairs.pairs.size());
  EXPECT_EQ(r.result.rows, r.set.rows.count);
  EXPECT_EQ(r.result.work, r.pairs.work + 2 * ((r.set.rows.count + 7) / 8)) << "two tests for each group of eight rows";
  for (int n = 0; n < 20 && r.parts.workLeft(); ++n) r.makeRows({{0, 0, 0}, kUpright}, 0.1);
  EXPECT_FALSE(r.parts.workLeft());
  const PairSet late = r.parts.search({{0, 0, 0}, kUpright}, 0.1, PairsOf::ContactSurface);
  EXPECT_TRUE(late.coarse) << "the rest of the tree is represented by inner nodes";
}

TEST(NoteContacts, ReportsTheContactsOfTheSolution) {
  SceneDescription d = test::toolAndObject(test::oneBallTree(1), test::oneBallTree(2));
  d.coupling.translation = 3;
  PartsRig r(std::move(d));
  const Configuration pose{{0, 0, 3}, kUpright};
  r.parts.memory.graphic = pose;
  r.makeRows(pose);
  r.parts.solve(r.set, r.target({0, 0, -0.5}));
  r.parts.keepActive(r.pairs);
  noteContacts(r.set, pose, r.parts);
  ASSERT_EQ(contacts(*r.rig.workspace).size(), 1u);
  const Contact& c = contacts(*r.rig.workspace)[0];
  EXPECT_NEAR(c.force, 1.5, 1e-5) << "3 N/mm times 0.5 mm";
  EXPECT_LT((c.normal - Vector3d::UnitZ()).norm(), 1e-6);
  EXPECT_LT((c.point - Vector3d(0, 0, 2)).norm(), 1e-6);
}

}  // namespace
}  // namespace spheretree::runtime
