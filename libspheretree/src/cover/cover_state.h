// SPDX-License-Identifier: GPL-3.0-or-later
// The state of a cover search: balls, samples of the surface, and who covers what at the present goal; and the moves
// that change it. A ball has the radius d(c), the distance from its centre to the surface, and covers the samples with
// gap = |p - c| - d(c) <= goal. The search that makes the moves: cover_search.h
#pragma once

#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <vector>

#include "base/ball.h"
#include "cover/uncovered_set.h"
#include "geometry/distance_field.h"
#include "geometry/sample_index.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

class CoverState {
 public:
  /// `field` must outlive the state. Before any move a goal is to be set.
  CoverState(const DistanceField& field, std::span<const Eigen::Vector3d> samples, std::vector<Ball> balls, std::uint64_t seed);

  const std::vector<Ball>& balls() const { return balls_; }
  std::uint64_t work() const { return work_; }    // triangles and points that refits have looked at
  std::uint64_t moves() const { return moves_; }  // balls moved by coverAll()
  bool isCovered() const { return open_.empty(); }

  /// Other balls, in place of all.
  void setBalls(std::span<const Ball> balls);
  /// The goal of the stand-off [mm]; forgets what is tabu, and the weights stay.
  void setGoal(double goal);
  /// One more sample, covered or open like the others.
  void append(const Eigen::Vector3d& sample);

  /// Move 1, take: gives the open samples, one at random after the other, each to the ball that has to give up least
  /// for it, until all are covered. False if that takes more than `max_moves`, or work() comes to more than `max_work`.
  bool coverAll(int max_moves, std::uint64_t max_work, const Progress& progress);
  /// Move 2, remove: the ball that is missed least leaves; what it alone covered is open. There must be two or more.
  void removeBall();
  /// Move 3, add: one more ball, where an open sample is; where none is, a copy of the ball that covers the most alone.
  void addBall();

  /// Largest gap of a sample [mm]. `guess`: a stand-off near it; it only saves time.
  double standOff(double guess) const;
  /// The balls that were moved or removed since the last call, as they were then.
  std::vector<Ball> takeLeft();

 private:
  struct Sample {
    std::uint32_t count = 0;  // balls that cover it
    std::uint32_t owner = 0;  // their exclusive or: the ball itself where there is one
    double weight = 1;        // more for every time it was hard to cover
  };
  struct Near {
    std::uint32_t sample;
    double gap;
  };
  struct Cell {                   // what a ball covers
    std::vector<Near> near{};     // samples of a gap up to near_to, all of them
    double near_to = -kInfinity;  // at least any goal since the ball moved; -infinity: unknown
    std::vector<std::uint32_t> covered{};
    double own = 0;          // weight of the samples that it alone covers
    std::uint64_t tabu = 0;  // the move until which it is asked last
    Ball seen;               // the ball when takeLeft() was last called
    bool has_moved = false;  // since then
  };

  void moveBall(std::size_t b, const Ball& to);
  void cover(std::uint32_t b);
  void take(std::uint32_t b, std::uint32_t s);
  void uncover(std::uint32_t b);
  void place(std::uint32_t s);
  std::uint32_t leastMissed() const;
  Ball ballFor(const Eigen::Vector3d& p) const;
  double comeInside(Ball& trial, double stand_off) const;
  double costToTake(std::uint32_t b, std::uint32_t s, double target, Ball& trial);

  const DistanceField& field_;
  std::uint64_t work_ = 0;
  std::uint64_t moves_ = 0;
  SampleIndex samples_;
  std::vector<Sample> state_;  // of the samples
  std::vector<Ball> balls_;    // radius d(c)
  std::vector<Cell> cells_;    // of the balls
  UncoveredSet open_;          // samples that no ball covers
  double goal_ = 0;
  std::uint64_t move_ = 0;  // number of the last, at this goal
  std::vector<Ball> left_;  // removed since takeLeft() was last called, as they were then
  std::vector<Eigen::Vector3d> patch_;
  std::vector<std::uint32_t> patch_samples_;
  std::mt19937_64 random_;
};

}  // namespace spheretree::builder
