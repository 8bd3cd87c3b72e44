// SPDX-License-Identifier: GPL-3.0-or-later
// The search for a tight cover in continuous space: one state, three moves, one budget. It lowers the stand-off of a
// number of balls, or finds few balls for a stand-off, and continues from the cover that the last call ended with.
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

/// What a search starts from.
struct ChosenBalls {
  std::vector<Ball> balls;               // radius d(c)
  std::vector<Eigen::Vector3d> samples;  // on the surface
  double start = 1.1;                    // the first goal, times the stand-off on the samples: what they miss is covered there; >= 1
  std::uint64_t seed = 1;                // of the search
};

struct SearchSettings {
  double step = 0.02;  // each goal of lower() is this share below the last, at first, and fit() removes this share of the balls; (0, 0.5)
  int moves = 1000;    // balls moved before a goal is given up, counted anew whenever all samples are covered; >= 0
  std::uint64_t work = 100'000'000;  // triangles and points looked at before lower() ends: bounds its time on any mesh
  int failures = 4;             // goals that lower() gives up, each halves the step; single balls in a row that fit() cannot remove; >= 0
  double removal_moves = 25;    // for each ball, moves that fit() makes for removals after the first that fails; >= 0
  double gap_spacing = 0.03;    // new samples are this far apart, as a share of the width of a patch; > 0
  double gap_tolerance = 0.02;  // holes shallower than this share of the stand-off may be left to the certificate; > 0
};

/// Sequential but for the search for gaps; the same calls give the same balls for any number of threads.
class CoverSearch {
 public:
  /// Covers what the mesh has between the samples too, at a stand-off that is found here. `mesh` and `field` must
  /// outlive the search.
  CoverSearch(const TriangleMesh& mesh, const DistanceField& field, ChosenBalls start, const SearchSettings& settings, Progress& progress);

  /// The best cover so far: inscribed balls that, grown by standOff(), cover the mesh but for gaps too small to sample.
  const std::vector<Ball>& balls() const { return best_; }
  double standOff() const { return stand_off_; }  // [mm]
  Cover cover() const;
  /// The samples given, then the uncovered points of the mesh as they were found.
  const std::vector<Eigen::Vector3d>& points() const { return points_; }

  /// Lowers the stand-off of the balls there are until it is at most `target` or the budget is spent.
  void lower(double target, Progress& progress);
  /// Adds balls, up to `max_balls`, until the stand-off is at most `wanted` [mm], then removes as many as it can; holes
  /// are as shallow as after close(). False, and the lowest stand-off found for `max_balls`, if they do not suffice.
  bool fit(double wanted, std::size_t max_balls, Progress& progress);
  /// Moves close the deeper half of the holes that are left to the certificate, for hardly more stand-off.
  void close(Progress& progress);

 private:
  bool coverAll(std::uint64_t max_work, Progress& progress);
  bool settle(double goal, double tolerance, std::uint64_t max_work, Progress& progress);
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
  std::uint64_t max_work_ = 0;                 // of lower()
  std::uint64_t removal_moves_ = 0;            // made so far for this stand-off
  std::pair<double, double> looked_for_ = {};  // goal and tolerance of the last search for gaps
  double fitted_to_ = 0;                       // the stand-off of fit() [mm]
  std::vector<Ball> best_;
  double stand_off_ = 0;
};

}  // namespace spheretree::builder
