// SPDX-License-Identifier: GPL-3.0-or-later
// Soft tissue that a tool with friction drags along. Subject: SceneObject::tissue and friction of scene.h
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <vector>

#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"
#include "support/random.h"
#include "support/shape_trees.h"
#include "support/soft_block.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using runtime::Mode;
using runtime::StepResult;

/// A block on body 1, and a tool that rubs on it; in large motion with a solver in lock step.
struct RubbedBlock {
  const test::SoftBlock& block;
  runtime::Scene scene;
  std::unique_ptr<runtime::Workspace> workspace;
  std::unique_ptr<tissue::MovingTissue> motion;
  tissue::TissueState states[2];
  double friction;
  int steps = 0;
  double taken = 0, max_taken = 0, given_back = 0;  // by friction, so far; what of it was given back [mJ]
  double over_cone = 0;                             // the most that a force across was above friction times that along the normal [N]

  RubbedBlock(const test::SoftBlock& of, SphereTree tool, double mu, double stiffness = 1, bool is_large = false)
      : block(of), friction(mu) {
    runtime::SceneDescription d;
    d.tool = std::move(tool);
    d.objects.push_back({});
    d.objects[0].tree = block.shared;
    d.objects[0].tissue = block.model;
    d.objects[0].friction = mu;
    d.objects[0].body = 1;
    d.coupling.translation = stiffness;
    std::string fault;
    EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
    workspace = std::make_unique<runtime::Workspace>(scene);
    if (!is_large) return;
    motion = tissue::MovingTissue::make(*scene.tissue(0), fault);
    states[0] = states[1] = motion->restState();
  }
  StepResult to(const Vector3d& p) {
    if (motion && steps++ % 10 == 0) {
      std::swap(states[0], states[1]);
      EXPECT_TRUE(aimTissue(0, states[0].surface, states[0].is_frozen, *workspace));
      motion->advance(tissueForces(0, *workspace), states[1]);
    }
    const StepResult r = step(scene, {p, {1, 0, 0, 0}}, Mode::Constrained, *workspace);
    for (const runtime::Contact& c : contacts(*workspace)) {
      over_cone = std::max(over_cone, c.friction.norm() - friction * c.force);
      taken -= 1e-3 * c.friction.dot(c.slip);
    }
    max_taken = std::max(max_taken, taken);
    given_back = std::max(given_back, max_taken - taken);
    return r;
  }
  StepResult along(const Vector3d& from, const Vector3d& to_place, double speed) {  // mm a step
    const int count = std::max(1, static_cast<int>(std::ceil((to_place - from).norm() / speed)));
    StepResult r;
    for (int i = 1; i <= count; ++i) r = to(from + (to_place - from) * i / count);
    return r;
  }
  StepResult rest(const Vector3d& p, int count = 60) {
    StepResult r;
    for (int i = 0; i < count; ++i) r = to(p);
    return r;
  }
  std::vector<float> forces() const {
    const std::span<const float> f = tissueForces(0, *workspace);
    return {f.begin(), f.end()};
  }
};

/// f . C f of forces on the pressed nodes, from the matrix of the file alone.
double givenBy(const std::vector<float>& forces) {
  const TissueResponse& response = test::block().tissue->response;
  double sum = 0;
  for (std::size_t i = 0; i < forces.size(); ++i)
    for (std::size_t k = 0; k < forces.size(); ++k)
      sum += static_cast<double>(forces[i]) * static_cast<double>(forces[k]) * static_cast<double>(response.column(i / 3, i % 3)[k]);
  return sum;
}

// Where contacts stick all of their points go with the tool. So by the principle of virtual work the tool's way times
// the force that it adds is  df . C df  of the forces on the nodes, and force over travel is that of spring and tissue
// in series.
TEST(RubbedTissue, AToolThatSticksFeelsTheSeriesOfCouplingAndTissue) {
  test::Random random(7);
  for (const double stiffness : {0.05, 1.0, 20.0})
    for (const double depth : {0.1, 1.0, 2.0}) {
      RubbedBlock rig(test::block(), test::oneBallTree(2), 2, stiffness);
      const double x = random.between(9, 15), y = random.between(8, 12), angle = random.between(0, 6);
      const Vector3d above(x, y, 14.2), aside = 0.05 * Vector3d(std::cos(angle), std::sin(angle), 0);
      rig.to(above);
      StepResult before = rig.to(above);
      for (double z = above.z(); before.graphic.position.z() > 14 - depth; z -= 0.01) before = rig.to({x, y, z});
      const Vector3d hand = before.graphic.position - before.wrench.force / stiffness;
      before = rig.rest(hand);
      const std::vector<float> pressed = rig.forces();
      const StepResult after = rig.along(hand, hand + aside, 0.01);
      std::vector<float> change = rig.forces();
      for (std::size_t i = 0; i < change.size(); ++i) change[i] -= pressed[i];
      const Vector3d force = after.wrench.force - before.wrench.force;
      const double found = -force.dot(aside) / aside.squaredNorm(), compliance = givenBy(change) / force.squaredNorm();
      EXPECT_GT(compliance, 1) << "mm/N: it is soft";
      EXPECT_NEAR(found, 1 / (1 / stiffness + compliance), 0.03 * found) << stiffness << " N/mm, " << depth << " mm deep";
      EXPECT_LT(force.cross(aside).norm(), 0.25 * force.norm() * aside.norm());
    }
}

// Drawn along, it slips in the end, and then the force across is friction times that along the normal.
TEST(RubbedTissue, AToolDrawnAlongSlipsByTheLaw) {
  for (const double mu : {0.1, 0.3}) {
    RubbedBlock rig(test::block(), test::oneBallTree(2), mu);
    rig.to({8, 10, 15});
    rig.along({8, 10, 15}, {8, 10, 12}, 0.02);
    rig.along({8, 10, 12}, {16, 10, 12}, 0.02);
    double across = 0, along = 0;
    Vector3d force = Vector3d::Zero();
    for (const runtime::Contact& c : contacts(*rig.workspace)) {
      across += c.friction.norm(), along += c.force, force += c.friction;
      EXPECT_GT(c.slip.x(), 1) << "of 20 mm/s";
    }
    EXPECT_NEAR(across, mu * along, 0.01 * across);
    EXPECT_LT(force.x(), -0.85 * across) << "most of it is along the way";
  }
}

void expectTheLaw(const RubbedBlock& rig) {
  EXPECT_LT(rig.over_cone, 1e-5);
  // Contacts that come and go, and tissue that waits, move the surface otherwise than the QP says. 24 other paths give
  // back 7e-8 mJ at most; 0.05 mJ is what a hand may be given.
  EXPECT_LT(rig.given_back, 1e-3) << "of " << rig.taken << " mJ";
}

// On any path no force is outside of its cone, friction takes energy all the time, and over a closed path the hand
// gains nothing.
TEST(RubbedTissue, OnAnyPathFrictionOnlyTakesEnergy) {
  test::Random random(11);
  for (int run = 0; run < 6; ++run) {
    const bool is_large = run % 3 == 0;
    const test::SoftBlock& block = is_large ? test::fineBlock() : test::block();
    const double radius = random.between(1.5, 3), mu = random.between(0.05, 1), stiffness = random.between(0.2, 2);
    RubbedBlock rig(block, test::oneBallTree(radius), mu, stiffness, is_large);
    std::vector<Vector3d> corners{{12, 10, 16}};
    for (int i = 0; i < 6; ++i) {
      const double x = random.between(8, 16), y = random.between(7, 13);
      corners.emplace_back(x, y, random.between(12, 14.5));
    }
    corners.push_back(corners.front());
    Vector3d last = corners[0], force = rig.to(last).wrench.force;
    double work = 0;
    for (std::size_t i = 1; i < corners.size(); ++i) {
      const int count = static_cast<int>((corners[i] - corners[i - 1]).norm() / 0.02);
      for (int k = 1; k <= count; ++k) {
        const Vector3d p = corners[i - 1] + (corners[i] - corners[i - 1]) * k / count, now = rig.to(p).wrench.force;
        work -= 0.5 * (force + now).dot(p - last);
        force = now, last = p;
      }
    }
    EXPECT_GT(work, -0.05) << run;
    EXPECT_LT(force.norm(), 1e-3);
    expectTheLaw(rig);
  }
}

// What counts is the motion against the surface: a body that carries the tissue is as a hand that goes the other way.
TEST(RubbedTissue, ABodyCarriesToolAndTissueAlong) {
  for (const bool is_large : {false, true}) {
    const test::SoftBlock& block = is_large ? test::fineBlock() : test::block();
    RubbedBlock carried(block, test::oneBallTree(2), 2, 1, is_large), dragged(block, test::oneBallTree(2), 2, 1, is_large);
    const Vector3d above(11, 9, 15), hand(11, 9, 12.5);
    for (RubbedBlock* const rig : {&carried, &dragged}) rig->to(above), rig->along(above, hand, 0.02), rig->rest(hand, 200);
    StepResult one, other;
    for (int i = 1; i <= 100; ++i) {
      const Vector3d way(0.01 * i, 0.004 * i, 0);
      EXPECT_TRUE(moveBody(1, {way, {1, 0, 0, 0}}, *carried.workspace));
      one = carried.to(hand);
      other = dragged.to(hand - way);
      EXPECT_LT(one.penetration, 0.1);
    }
    one = carried.rest(hand, 200), other = dragged.rest(hand - Vector3d(1, 0.4, 0), 200);
    EXPECT_GT(other.wrench.force.x(), 0.02);
    EXPECT_LT((one.wrench.force - other.wrench.force).norm(), 0.05 * other.wrench.force.norm()) << is_large;
    expectTheLaw(carried);
    expectTheLaw(dragged);
  }
}

// Held aside, a tool that sticks holds the tissue with it; let go, both come back.
TEST(RubbedTissue, InLargeMotionSurfaceAndToolStayTogether) {
  RubbedBlock rig(test::fineBlock(), test::oneBallTree(3), 2, 1, true);
  const Vector3d above(12, 10, 16), hand(12, 10, 13);
  rig.to(above), rig.along(above, hand, 0.02);
  const Vector3d before = rig.rest(hand, 500).wrench.force;
  rig.along(hand, hand + Vector3d(1.5, 0, 0), 0.01);
  const StepResult aside = rig.rest(hand + Vector3d(1.5, 0, 0), 500), later = rig.rest(hand + Vector3d(1.5, 0, 0), 200);
  EXPECT_LT(aside.wrench.force.x(), -0.03);
  EXPECT_LT((later.wrench.force - aside.wrench.force).norm(), 0.02 * aside.wrench.force.norm()) << "it does not creep";
  const std::vector<float> forces = rig.forces();
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < forces.size(); i += 3) sum += Vector3d(forces[i], forces[i + 1], forces[i + 2]);
  EXPECT_LT((sum + later.wrench.force).norm(), 0.02 * later.wrench.force.norm()) << "all of it is on the tissue";
  rig.along(hand + Vector3d(1.5, 0, 0), hand, 0.01);
  // Contacts that came while it was held aside keep their shear. At 16 other places 0.02 of the force is left on
  // average, 0.13 at most.
  EXPECT_LT((rig.rest(hand, 500).wrench.force - before).norm(), 0.25 * before.norm());
  expectTheLaw(rig);
}

}  // namespace
}  // namespace spheretree::builder
