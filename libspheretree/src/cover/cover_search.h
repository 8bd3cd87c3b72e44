// SPDX-License-Identifier: GPL-3.0-or-later
// The search for a tight cover in continuous space: one state, three moves, one work budget. It lowers the stand-off
// for a given number of balls, or finds few balls for a given stand-off, and continues from the cover of the last call.
// docs/algorithms/cover/cover_search.md
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/ball.h"
#include "cover/cover_state.h"
#include "cover/gap_sampler.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct Cover {
  std::vector<Ball> balls;  // radius = d(c) + stand_off
  double stand_off = 0;     // h [mm]
};

/// The start of a search.
struct SearchStart {
  std::vector<Ball> balls{};               // radius d(c)
  std::vector<Eigen::Vector3d> samples{};  // on the surface
  std::size_t count = 0;                   // of the balls of the search, which adds or removes some first; 0: as many as are given
  std::uint64_t seed = 1;                  // of the random numbers of the search
};

inline constexpr int kMovesBeside = 10;  // moves that a search gets beside those for each of its balls

struct SearchSettings {
  double step = 0.02;  // each goal of lower() is this share below the last one, initially; fit() removes this share of the balls; (0, 0.5)
  double last_step = 0.002;          // lower() ends when failures have halved its step to less than this share; > 0
  int moves = 1000;                  // moves before a goal is given up; counted from the last time that all samples were covered; >= 0
  std::uint64_t work = 100'000'000;  // triangles and points tested before lower() ends: limits its time on any mesh
  int failures = 4;                  // consecutive balls that fit() fails to remove before it ends; >= 0
  double removal_moves = 25;         // moves of fit() for removals after the first failure, for each ball; >= 0
  double gap_spacing = 0.03;         // distance of new samples, as a share of the width of a patch; > 0
  double gap_tolerance = 0.02;       // gaps shallower than this share of the stand-off may be left to certification; > 0
};

/// Sequential except for the search for gaps; the same calls give the same balls for any number of threads.
class CoverSearch {
 public:
  /// Distributes the balls on the samples, then also covers the mesh between the samples, with a stand-off that is
  /// determined here. `mesh` and `field` must outlive the search.
  CoverSearch(const TriangleMesh& mesh, const DistanceField& field, SearchStart start, const SearchSettings& settings, Progress& progress);

  /// The best cover so far: inscribed balls that, grown by standOff(), cover the mesh except for gaps too small to
  /// sample.
  const std::vector<Ball>& balls() const { return best_; }
  double standOff() const { return stand_off_; }  // [mm]
  Cover cover() const;
  /// The given samples, then the uncovered points of the mesh in the order in which they were found.
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

  /// Lowers the stand-off of the current balls until it is at most `target` or the work budget is spent.
  void lower(double target, Progress& progress);
  /// Adds balls, up to `max_balls`, until the stand-off is at most `wanted` [mm], then removes as many as possible;
  /// gaps are as shallow as after close(). Returns false if `max_balls` do not suffice; the cover then has the smallest
  /// stand-off found for `max_balls`.
  bool fit(double wanted, std::size_t max_balls, Progress& progress);
  /// Moves balls to close the deeper half of the gaps that would be left to certification, with hardly more stand-off.
  void close(Progress& progress);

 private:
  bool coverAll(std::uint64_t max_work, Progress& progress);
  bool settle(double goal, double tolerance, std::uint64_t max_work, Progress& progress);
  enum class Extent { Samples, Mesh };  // what is to be covered
  void lower(double target, double last_step, Extent extent, Progress& progress);
  void reachFrom(double goal, Extent extent, Progress& progress);
  bool reach(double goal, Extent extent, std::uint64_t max_work, Progress& progress);
  void setCount(std::size_t balls);
  bool change(std::size_t balls, double goal, Progress& progress);
  void addBalls(double wanted, std::size_t max_balls, Progress& progress);
  void removeBalls(Progress& progress);
  std::uint64_t work() const { return looked_at_ + state_.work(); }
  std::uint64_t attempt() const;
  double toleranceAt(double goal) const;
  void keep(double goal);

  SearchSettings settings_;
  std::vector<Eigen::Vector3d> points_;
  GapSampler sampler_;
  CoverState state_;
  std::uint64_t looked_at_ = 0;                // triangles searched for gaps, in units of work
  std::uint64_t max_work_;                     // work budget of lower()
  std::uint64_t removal_moves_ = 0;            // moves for removals so far, at this stand-off
  std::pair<double, double> looked_for_ = {};  // goal and tolerance of the last search for gaps
  double fitted_to_ = 0;                       // the stand-off of fit() [mm]
  std::vector<Ball> best_;
  double stand_off_ = 0;
};

}  // namespace spheretree::builder
