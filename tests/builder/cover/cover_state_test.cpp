// SPDX-License-Identifier: GPL-3.0-or-later
#include "cover/cover_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// A box, samples on it, and balls at random places inside.
struct Trial {
  TriangleMesh mesh = test::boxMesh({-4, -3, -2}, {4, 3, 2});
  DistanceField field{mesh};
  std::vector<Vector3d> samples;
  std::vector<Ball> balls;
  test::Random random;

  explicit Trial(std::uint64_t seed) : random(seed) {
    while (samples.size() < 400) samples.push_back(field.nearest(random.inBox({-5, -4, -3}, {5, 4, 3})).point);
    while (balls.size() < 12) {
      const Vector3d c = random.inBox({-4, -3, -2}, {4, 3, 2});
      balls.push_back({c, -field.signedDistance(c)});
    }
  }
  double standOff(const std::vector<Ball>& of) const {
    double largest = 0;
    for (const Vector3d& p : samples) {
      double smallest = 1e9;
      for (const Ball& b : of) smallest = std::min(smallest, (p - b.centre).norm() - b.radius);
      largest = std::max(largest, smallest);
    }
    return largest;
  }
};

TEST(CoverState, OwnersOfSamplesAreCorrectAfterAnyMoves) {
  const Progress progress;
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    Trial trial(seed);
    CoverState state(trial.field, trial.samples, trial.balls, seed);
    double goal = 1.3;
    state.setGoal(goal);
    for (int move = 0; move < 300; ++move) {
      const auto kind = trial.random.below(6);
      if (kind < 2) {
        (void)state.coverAll(5, ~std::uint64_t{0}, progress);
      } else if (kind == 2 && state.balls().size() > 2) {
        state.removeBall();
      } else if (kind == 3 && state.balls().size() < 40) {
        state.addBall();
      } else if (kind == 4) {
        trial.samples.push_back(trial.field.nearest(trial.random.inBox({-5, -4, -3}, {5, 4, 3})).point);
        state.append(trial.samples.back());
      } else {
        goal = trial.random.inBox({0.6, 0, 0}, {2, 1, 1}).x();
        state.setGoal(goal);
      }
      const double wanted = trial.standOff(state.balls());
      ASSERT_EQ(state.isCovered(), wanted <= goal) << "move " << move << " of kind " << kind;
      ASSERT_NEAR(state.standOff(trial.random.inBox({0, 0, 0}, {3, 1, 1}).x()), wanted, 1e-12) << "whatever the guess";
      for (const Ball& b : state.balls()) ASSERT_NEAR(b.radius, -trial.field.signedDistance(b.centre), 1e-9) << "balls stay inscribed";
    }
  }
}

TEST(CoverState, TellsWhichBallsLeftTheirPlace) {
  const Progress progress;
  Trial trial(4);
  CoverState state(trial.field, trial.samples, trial.balls, 4);
  state.setGoal(1.0);
  const auto key = [](const Ball& b) { return std::array<double, 4>{b.centre.x(), b.centre.y(), b.centre.z(), b.radius}; };
  for (int round = 0; round < 40; ++round) {
    std::multiset<std::array<double, 4>> before, after;
    for (const Ball& b : state.balls()) before.insert(key(b));
    (void)state.coverAll(3, ~std::uint64_t{0}, progress);
    if (round % 5 == 1) state.removeBall();
    if (round % 5 == 2) state.addBall();
    for (const Ball& b : state.balls()) after.insert(key(b));
    std::multiset<std::array<double, 4>> left;
    for (const Ball& b : state.takeLeft()) left.insert(key(b));
    for (const auto& ball : before) {  // every ball that has moved or vanished is reported
      if (after.count(ball) >= before.count(ball)) continue;
      ASSERT_GE(left.count(ball), before.count(ball) - after.count(ball)) << "round " << round;
    }
    EXPECT_TRUE(state.takeLeft().empty()) << "once";
  }
}

TEST(CoverState, TheSameSeedMakesTheSameMoves) {
  const Progress progress;
  const auto run = [&](std::uint64_t seed) {
    const Trial trial(5);
    CoverState state(trial.field, trial.samples, trial.balls, seed);
    state.setGoal(0.9);
    (void)state.coverAll(200, ~std::uint64_t{0}, progress);
    std::vector<double> all;
    for (const Ball& b : state.balls()) all.insert(all.end(), {b.centre.x(), b.centre.y(), b.centre.z(), b.radius});
    return all;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(CoverState, StopsWhereMovesOrWorkEnd) {
  const Progress progress;
  Trial trial(6);
  CoverState state(trial.field, trial.samples, trial.balls, 6);
  state.setGoal(1e-3);  // out of reach of twelve balls
  EXPECT_FALSE(state.coverAll(7, ~std::uint64_t{0}, progress));
  EXPECT_EQ(state.moves(), 7u);
  const std::uint64_t work = state.work();
  EXPECT_GT(work, 0u);
  EXPECT_FALSE(state.coverAll(1000, work, progress));
  EXPECT_LE(state.moves(), 9u) << "the move that goes beyond it is the last";
}

}  // namespace
}  // namespace spheretree::builder
