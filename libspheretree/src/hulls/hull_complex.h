// SPDX-License-Identifier: GPL-3.0-or-later
// Inscribed balls, hulls that share them, and the hull that holds each sample of the surface at the least cost.
// docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "base/ball.h"
#include "hulls/fit_task.h"
#include "hulls/simplex.h"

namespace spheretree::builder {

inline constexpr int kBareRounds = 4;  // of more samples where the surface is bare

/// A ball in the place of another, and what follows from that; hull_change.h finds it.
struct HullChange {
  std::uint32_t from = 0;  // ball that goes
  std::uint32_t to = 0;    // a neighbour that stays, or the number of balls for a new one
  Ball ball{};
  double cost = kInfinity;    // largest of the hulls and samples that are worse for it [mm]
  double energy = kInfinity;  // of all hulls around it
  std::vector<Simplex> made{};
  std::vector<std::pair<std::uint32_t, double>> costs{};        // (sample, new cost)
  std::vector<std::pair<std::uint32_t, std::uint32_t>> kept{};  // (simplex, sample) for simplices that stay
};

/// Deterministic for any number of threads.
class HullComplex {
 public:
  /// No balls, and all samples of the task, which must outlive the complex.
  explicit HullComplex(const FitTask& task);

  const FitTask& task() const { return *task_; }
  const std::vector<Ball>& balls() const { return balls_; }
  const std::vector<Simplex>& simplices() const { return simplices_; }  // some are not alive
  const std::vector<FitSample>& samples() const { return samples_; }
  double most() const { return most_; }  // that a hull and a sample may cost [mm]

  /// Living simplices of a ball.
  std::vector<std::uint32_t> around(std::uint32_t v) const;
  /// Balls that share a living simplex with it, ascending.
  std::vector<std::uint32_t> neighbours(std::uint32_t v) const;

  /// Adds balls below samples, far from each other. Whether there are any.
  bool addFirstBalls();
  /// Joins these balls, instead of those now, and more of them until all samples are held, or as many as may be joined.
  void join(std::vector<Ball> balls);
  /// Adds samples where the grown hulls leave the surface bare. Whether there are such places.
  bool addBare();
  void apply(const HullChange& change);
  /// Leaves out hulls whose samples others hold, those with the fewest first.
  void prune();
  /// Leaves out simplices that are not alive; the others get new numbers.
  void compact();
  /// Back to `before`, an earlier state, except that samples which were added since stay.
  void restore(HullComplex before);
  /// From now on, hulls and samples may also cost what was left for places between samples.
  void allowAll() { most_ = all_; }

 private:
  void addBalls(double enough, std::size_t count);
  void holdSamples();

  const FitTask* task_;
  double all_;  // the tolerance less what proofs take [mm]
  double most_;
  std::vector<Ball> balls_{};  // inscribed
  std::vector<Simplex> simplices_{};
  std::vector<std::vector<std::uint32_t>> of_{};  // (ball) its simplices, and some that are gone
  std::vector<FitSample> samples_;
};

}  // namespace spheretree::builder
