// SPDX-License-Identifier: GPL-3.0-or-later
// The solver behind the steps; builder/tissue/large_motion_test.cpp tests both together.
#include "spheretree/tissue/moving_tissue.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "spheretree/tissue/rest_stiffness.h"
#include "support/soft_box.h"

namespace spheretree::tissue {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

/// A box that is held below. Its response is the inverse of its stiffness at rest.
Tissue pressedBox() {
  const Vector3d size(4, 3, 5);
  Tissue tissue = test::softBox(size, {2, 2, 2}, {15, 0.45, 1040}, test::isBelow, 0.3);
  test::Field nodes;
  std::vector<Eigen::Index> free, pressed;  // rows of the matrix; columns of its inverse
  for (std::uint32_t i = 0; i < tissue.nodes.size(); ++i) {
    nodes.push_back(test::at(tissue, i));
    if (test::isBelow(nodes[i])) continue;
    const bool is_outside = nodes[i].minCoeff() < 1e-9 || (size - nodes[i]).minCoeff() < 1e-9;
    if (is_outside) tissue.response.pressed.push_back(i);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      if (is_outside) pressed.push_back(std::ssize(free));
      free.push_back(3 * Eigen::Index{i} + axis);
    }
  }
  const MatrixXd stiffness(restStiffness(nodes, tissue.tetrahedra, tissue.material)), inverse = stiffness(free, free).inverse();
  const Eigen::MatrixXf compliance = inverse(pressed, pressed).cast<float>();
  tissue.response.matrix.assign(compliance.reshaped().begin(), compliance.reshaped().end());
  return tissue;
}

/// A box in motion, and what it says.
struct MovingBox {
  Tissue tissue = pressedBox();
  std::unique_ptr<MovingTissue> motion;
  TissueState state;

  MovingBox() {
    std::string fault;
    motion = MovingTissue::make(tissue, fault);
    EXPECT_EQ(fault, "");
    state = motion->restState();
  }
  /// `force` on the last node, a corner at the top.
  std::vector<float> forcesOf(const Vector3d& force) const {
    std::vector<float> forces(3 * tissue.response.pressed.size(), 0.0f);
    for (std::size_t axis = 0; axis < 3; ++axis)
      forces[forces.size() - 3 + axis] = static_cast<float>(force[static_cast<Eigen::Index>(axis)]);
    return forces;
  }
  void settle(const std::vector<float>& forces) {
    for (int i = 0; i < 200; ++i) motion->advance(forces, state);
  }
  /// C f: the displacement of the pressed nodes by the compliance at rest.
  Eigen::VectorXf linear(const std::vector<float>& forces) const {
    const auto n = static_cast<Eigen::Index>(forces.size());
    return Eigen::Map<const Eigen::MatrixXf>(tissue.response.matrix.data(), n, n) * Eigen::Map<const Eigen::VectorXf>(forces.data(), n);
  }
  Eigen::VectorXf base() const { return Eigen::Map<const Eigen::VectorXf>(state.surface.data(), std::ssize(state.surface)); }
  /// The displacements of the pressed nodes in the solver's state.
  Eigen::VectorXf solved() const {
    Eigen::VectorXf out(std::ssize(state.surface));
    for (std::size_t i = 0; i < tissue.response.pressed.size(); ++i)
      out.segment<3>(static_cast<Eigen::Index>(3 * i)) = state.displacements[tissue.response.pressed[i]].cast<float>();
    return out;
  }
};

TEST(MovingTissue, AtRestNothingIsDisplaced) {
  MovingBox box;
  EXPECT_EQ(box.state.displacements, test::noForces(box.tissue));
  EXPECT_EQ(box.state.surface, box.forcesOf(Vector3d::Zero()));
  for (int i = 0; i < 5; ++i) box.motion->advance(box.forcesOf(Vector3d::Zero()), box.state);
  EXPECT_LT(box.base().norm(), 1e-9f);
  EXPECT_FALSE(box.state.is_frozen);
}

// The base is x(f) - C f, so that the steps, which add C f, are at the state of the solver.
TEST(MovingTissue, BaseAndComplianceAddUpToTheStateOfTheSolver) {
  MovingBox box;
  const std::vector<float> forces = box.forcesOf({0.01, 0.004, -0.02});
  box.settle(forces);
  EXPECT_FALSE(box.state.is_frozen);
  EXPECT_GT(box.solved().norm(), 1.0f);
  EXPECT_GT(box.base().norm(), 0.1f * box.solved().norm()) << "this is large motion";
  EXPECT_LT((box.base() + box.linear(forces) - box.solved()).norm(), 1e-5f * box.solved().norm());
}

TEST(MovingTissue, TheBaseOfASmallForceIsOfSecondOrder) {
  float last = 0;
  for (const double size : {1.0, 0.5, 0.25}) {
    MovingBox box;
    const std::vector<float> forces = box.forcesOf(size * Vector3d(0.001, 0.0004, -0.001));
    box.settle(forces);
    EXPECT_LT(box.base().norm(), 0.1f * box.linear(forces).norm());
    if (last > 0) {
      EXPECT_NEAR(box.base().norm() / last, 0.25f, 0.04f) << "half of the force, a quarter of the base";
    }
    last = box.base().norm();
  }
}

// With the way w from the last base to x(f) - C f, the share is -share_before (w_before . d) / d . d, d = w - w_before,
// from 5 % to the whole way (U. Kuettler, W. Wall 2008). The first way after rest is covered to 5 %.
TEST(MovingTissue, TheBaseMovesByTheShareOfAitken) {
  MovingBox box;
  Eigen::VectorXf last = box.base(), way_before = last;
  float share = 1;
  int smallest = 0, between = 0, whole = 0;
  for (int i = 0; i < 60; ++i) {
    const std::vector<float> forces = box.forcesOf((i % 20 < 10 ? 0.01 : -0.005) * Vector3d(1, 0.4, -2));
    box.motion->advance(forces, box.state);
    const Eigen::VectorXf way = box.solved() - box.linear(forces) - last, change = way - way_before;
    share = std::clamp(-share * way_before.dot(change) / change.squaredNorm(), 0.05f, 1.0f);
    EXPECT_LT((box.base() - last - share * way).norm(), 1e-3f * way.norm() + 1e-6f) << "state " << i << ", share " << share;
    (share <= 0.05f ? smallest : share < 1 ? between : whole)++;
    last = box.base(), way_before = way;
  }
  EXPECT_GT(smallest, 2);
  EXPECT_GT(between, 2);
  EXPECT_GT(whole, 2);
}

TEST(MovingTissue, AWildForceFreezesTheLastGoodState) {
  MovingBox box;
  const std::vector<float> forces = box.forcesOf({0.01, 0, 0});
  box.settle(forces);
  const TissueState before = box.state;
  box.motion->advance(box.forcesOf({std::numeric_limits<double>::quiet_NaN(), 0, 0}), box.state);
  EXPECT_TRUE(box.state.is_frozen);
  EXPECT_EQ(box.state.displacements, before.displacements);
  EXPECT_EQ(box.state.surface, before.surface);
  box.motion->advance(forces, box.state);
  EXPECT_FALSE(box.state.is_frozen) << "and goes on";
  EXPECT_LT((box.base() - Eigen::Map<const Eigen::VectorXf>(before.surface.data(), std::ssize(before.surface))).norm(), 1e-4f);
}

TEST(MovingTissue, AResetGivesTheSameBytesAgain) {
  MovingBox box;
  const auto run = [&] {
    for (int i = 0; i < 10; ++i) box.motion->advance(box.forcesOf(0.003 * i * Vector3d(1, 0.4, -1)), box.state);
    return box.state;
  };
  const TissueState first = run(), without_reset = run();
  EXPECT_NE(without_reset.surface, first.surface);
  box.motion->reset();
  const TissueState again = run();
  EXPECT_EQ(again.surface, first.surface);
  EXPECT_EQ(again.displacements, first.displacements);
}

TEST(MovingTissue, RefusesTissueWithoutAResponseOrThatIsNotHeld) {
  const auto faultOf = [](const Tissue& tissue) {
    std::string fault;
    EXPECT_EQ(MovingTissue::make(tissue, fault), nullptr);
    return fault;
  };
  Tissue tissue = pressedBox();
  tissue.response = {};
  EXPECT_EQ(faultOf(tissue), "the tissue has no response to forces");
  tissue = pressedBox();
  tissue.fixed.clear();
  EXPECT_NE(faultOf(tissue).find("not held"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::tissue
