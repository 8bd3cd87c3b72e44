// SPDX-License-Identifier: GPL-3.0-or-later
// The `cover` builder: every level by itself, as tight as its number of spheres allows.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "base/ball.h"
#include "cover/choose_balls.h"
#include "cover/cover_search.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Covers of one mesh. What a call finds, the next continues: the medial pool, the levels above the leaves, and with a
/// tolerance the leaves themselves, which balls are added to or removed from.
class CoverBuilder {
 public:
  /// `mesh` and `field` must outlive the builder.
  CoverBuilder(const TriangleMesh& mesh, const DistanceField& field) : mesh_(mesh), field_(field) {}

  /// Balls of each level, deepest first computed; no parents: hierarchy.h groups them. A level has at most
  /// branching^level balls and no more than the level below. With a tolerance, the leaves are the fewest found whose
  /// stand-off stays within it; if even the whole budget does not reach it, the whole budget is used. The same sequence
  /// of calls gives the same balls for any number of threads. Calls may differ in levels, branching, most_leaves and
  /// tolerance_mm; another quality or seed starts anew.
  LevelBalls build(const BuildSettings& settings, Progress& progress);

 private:
  void fitPool(std::size_t spheres, Progress& progress);
  std::size_t guessLeaves(double stand_off, std::size_t max_leaves, Progress& progress);
  CoverSearch startSearch(std::size_t spheres, Progress& progress) const;
  const Cover& cover(std::size_t spheres, Progress& progress);
  Cover coverWithin(double stand_off, std::size_t max_leaves, Progress& progress);
  LevelBalls levelsAbove(Cover leaves, std::size_t full, const BuildSettings& settings, Progress& progress);

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  Quality quality_ = Quality::Standard;
  std::uint64_t seed_ = 0;
  bool is_soft_ = false;
  std::vector<Ball> pool_;
  std::size_t pool_samples_ = 0;         // points that the pool was made from
  std::size_t fitted_ = 0;               // spheres that the effort is made for
  std::map<std::size_t, Cover> covers_;  // by their number of spheres
  std::optional<CoverSearch> leaves_;    // of the last tolerance
};

}  // namespace spheretree::builder
