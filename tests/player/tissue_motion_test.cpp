// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/tissue_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <vector>

#include "support/shape_trees.h"
#include "support/soft_block.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;

struct BallOnBlock {
  runtime::Scene scene;
  std::unique_ptr<runtime::Workspace> workspace;
  std::unique_ptr<TissueMotion> tissue;

  explicit BallOnBlock(TissueMotion::Clock clock) {
    runtime::SceneDescription d;
    d.tool = test::oneBallTree(3);
    d.objects.resize(2);
    d.objects[0].tree = test::oneBallTree(2);  // rigid and far away
    d.objects[0].pose.position = {100, 0, 0};
    d.objects[1].tree = test::fineBlock().shared;
    d.objects[1].tissue = test::fineBlock().model;
    std::string fault;
    EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
    workspace = std::make_unique<runtime::Workspace>(scene);
    tissue = std::make_unique<TissueMotion>(scene, clock);
  }
  runtime::StepResult to(const Vector3d& p) { return step(scene, {p, {1, 0, 0, 0}}, runtime::Mode::Constrained, *workspace); }
};

Vector3d pathAt(std::uint64_t tick) {
  const double t = static_cast<double>(tick) / 1000;
  return {12 + 0.5 * std::sin(9 * t), 10, 16 - 2 * std::min(1.0, 2 * t)};
}

TEST(TissueMotion, AReplayTakesTheSameStatesAndGivesTheSameBytes) {
  BallOnBlock one(TissueMotion::Clock::Stepped), other(TissueMotion::Clock::Replay);
  std::uint32_t last = 0;
  for (std::uint64_t tick = 0; tick < 600; ++tick) {
    const std::uint32_t states = one.tissue->take(tick, *one.workspace);
    const runtime::StepResult a = one.to(pathAt(tick));
    EXPECT_EQ(other.tissue->take(tick, *other.workspace, states != last), states);
    const runtime::StepResult b = other.to(pathAt(tick));
    last = states;
    ASSERT_EQ(a.wrench.force, b.wrench.force) << tick;
    ASSERT_EQ(a.graphic.position, b.graphic.position) << tick;
  }
  EXPECT_GT(last, 30u);
  EXPECT_LT(last, 60u) << "one every 10 ms, from the first touch on";
  const TissueShapes& shapes = one.tissue->shapes();
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_TRUE(shapes[0].empty());
  float deepest = 0;
  for (const Eigen::Vector3f& u : shapes[1]) deepest = std::min(deepest, u.z());
  EXPECT_LT(deepest, -0.3f);
}

TEST(TissueMotion, AThreadOfItsOwnComesToTheSameForce) {
  BallOnBlock stepped(TissueMotion::Clock::Stepped), real(TissueMotion::Clock::Real);
  runtime::StepResult a, b;
  for (std::uint64_t tick = 0; tick < 1500; ++tick) {
    stepped.tissue->take(tick, *stepped.workspace);
    a = stepped.to(pathAt(std::min<std::uint64_t>(tick, 600)));
  }
  std::uint32_t states = 0;
  for (std::uint64_t tick = 0; states < 150; ++tick) {  // as slow as the solver is on this machine
    states = real.tissue->take(tick, *real.workspace);
    b = real.to(pathAt(std::min<std::uint64_t>(tick, 600)));
    std::this_thread::sleep_for(std::chrono::microseconds(300));
  }
  EXPECT_GT(a.wrench.force.z(), 0.03);
  EXPECT_NEAR(b.wrench.force.z(), a.wrench.force.z(), 0.05 * a.wrench.force.z());
}

TEST(TissueMotion, ARestartBeginsAtTheShapeAtRest) {
  BallOnBlock stepped(TissueMotion::Clock::Stepped);
  std::vector<Vector3d> first, again;
  for (std::vector<Vector3d>* forces : {&first, &again}) {
    for (std::uint64_t tick = 0; tick < 400; ++tick) {
      stepped.tissue->take(tick, *stepped.workspace);
      forces->push_back(stepped.to(pathAt(tick)).wrench.force);
    }
    runtime::reset(*stepped.workspace);
    stepped.tissue->restart();
  }
  EXPECT_EQ(first, again);
  EXPECT_GT(first.back().z(), 0.01);

  BallOnBlock real(TissueMotion::Clock::Real);
  std::uint32_t states = 0;
  for (std::uint64_t tick = 0; states < 20; ++tick) states = real.tissue->take(tick, *real.workspace), (void)real.to(pathAt(400));
  runtime::reset(*real.workspace);
  real.tissue->restart();  // while the solver is busy: it takes effect when the solver is done
  const auto isBent = [&] {
    const std::vector<Eigen::Vector3f>& shape = real.tissue->shapes()[1];
    return std::any_of(shape.begin(), shape.end(), [](const Eigen::Vector3f& u) { return u != Eigen::Vector3f(0, 0, 0); });
  };
  for (std::uint64_t tick = 0; tick < 20'000 && isBent(); ++tick) {
    states = real.tissue->take(tick, *real.workspace);
    (void)real.to({12, 10, 40});
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_FALSE(isBent());
}

TEST(TissueMotion, TissueThatNothingTouchesCostsNothing) {
  BallOnBlock far(TissueMotion::Clock::Stepped);
  std::uint32_t states = 0;
  for (std::uint64_t tick = 0; tick < 1200; ++tick) {
    states = far.tissue->take(tick, *far.workspace);
    (void)far.to({12, 10, 40});
  }
  EXPECT_EQ(states, 0u);
}

}  // namespace
}  // namespace spheretree::player
