// SPDX-License-Identifier: GPL-3.0-or-later
// The state of a cover search (balls, samples of the surface, and the balls that cover each sample at the current goal)
// and the moves that change it. A ball has the radius d(c), the distance from its centre to the surface, and covers the
// samples with gap = |p - c| - d(c) <= goal. The search that makes the moves: cover_search.h
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
  /// `field` must outlive the state. setGoal() must be called before any move.
  CoverState(const DistanceField& field, std::span<const Eigen::Vector3d> samples, std::vector<Ball> balls, std::uint64_t seed);

  const std::vector<Ball>& balls() const { return balls_; }
  std::uint64_t work() const { return work_; }    // triangles and points that refits have tested
  std::uint64_t moves() const { return moves_; }  // balls moved by coverAll()
  bool isCovered() const { return open_.empty(); }

  /// Replaces all balls.
  void setBalls(std::span<const Ball> balls);
  /// Sets the goal of the stand-off [mm]; clears the tabu marks and keeps the weights.
  void setGoal(double goal);
  /// Adds a sample.
  void append(const Eigen::Vector3d& sample);

  /// Move 1, take: repeatedly picks a random uncovered sample and gives it to the ball that loses the least for it,
  /// until all samples are covered. Returns false if that would exceed `max_moves` moves or `max_work` of work().
  bool coverAll(int max_moves, std::uint64_t max_work, const Progress& progress);
  /// Move 2, remove: removes the ball with the smallest loss; the samples that it alone covered become uncovered. There
  /// must be at least two balls.
  void removeBall();
  /// Move 3, add: adds a ball at an uncovered sample; if there is none, a copy of the ball that alone covers the most
  /// weight.
  void addBall();

  /// Largest gap of a sample [mm]. `guess`: an estimate of the stand-off; it only saves time.
  double standOff(double guess) const;
  /// The balls that were moved or removed since the last call, in their state at that call.
  std::vector<Ball> takeLeft();

 private:
  struct Sample {
    std::uint32_t count = 0;  // number of balls that cover it
    std::uint32_t owner = 0;  // exclusive or of their indices: the index itself if there is one ball
    double weight = 1;        // increases each time that the sample was hard to cover
  };
  struct Near {
    std::uint32_t sample;
    double gap;
  };
  struct Cell {                   // the samples that a ball covers
    std::vector<Near> near{};     // all samples with a gap up to near_to
    double near_to = -kInfinity;  // at least every goal since the ball moved; -infinity: unknown
    std::vector<std::uint32_t> covered{};
    double own = 0;          // weight of the samples that only this ball covers
    std::uint64_t tabu = 0;  // until this move other balls are preferred
    Ball seen;               // state of the ball at the last takeLeft()
    bool has_moved = false;  // since the last takeLeft()
  };

  void moveBall(std::size_t b, const Ball& to);
  void cover(std::uint32_t b);
  void take(std::uint32_t b, std::uint32_t s);
  void uncover(std::uint32_t b);
  void place(std::uint32_t s);
  std::uint32_t smallestUsefulBall() const;
  Ball ballFor(const Eigen::Vector3d& p) const;
  double openWeight(const Ball& ball) const;
  double comeInside(Ball& trial, double stand_off) const;
  double costToTake(std::uint32_t b, std::uint32_t s, double target, Ball& trial);

  const DistanceField& field_;
  std::uint64_t work_ = 0;
  std::uint64_t moves_ = 0;
  SampleIndex samples_;
  std::vector<Sample> state_;  // of the samples
  std::vector<Ball> balls_;    // radius d(c)
  std::vector<Cell> cells_;    // of the balls
  UncoveredSet open_;          // samples outside all balls
  double goal_ = 0;
  std::uint64_t move_ = 0;  // number of the last move at this goal
  std::vector<Ball> left_;  // balls removed since the last takeLeft(), in their state at that call
  std::vector<Eigen::Vector3d> patch_;
  std::vector<std::uint32_t> patch_samples_;
  std::mt19937_64 random_;
};

}  // namespace spheretree::builder
