// SPDX-License-Identifier: GPL-3.0-or-later
// The `cover` builder: each level is a cover of its own, with the smallest stand-off for its number of spheres.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "base/ball.h"
#include "cover/cover_search.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Covers of one mesh. A call continues from the results of earlier calls: the levels above the
/// leaves, and with a tolerance also the leaves, to which it adds balls or from which it removes some.
class CoverBuilder {
 public:
  /// `mesh` and `field` must outlive the builder.
  CoverBuilder(const TriangleMesh& mesh, const DistanceField& field) : mesh_(mesh), field_(field) {}

  /// The balls of each level, computed from the deepest level up; without parents, since hierarchy.h groups them. A
  /// level has at most branching^level balls, and at most as many as the level below. With a tolerance, the leaves are
  /// the smallest set that was found whose stand-off stays within it; if the largest allowed number of leaves does not
  /// suffice, that number is used. The same sequence of calls gives the same balls for any number of threads. Calls may
  /// differ in levels, branching, max_leaves and tolerance_mm; with another quality or seed the builder starts again.
  /// `start`: levels of balls of another builder, from which the searches start, the same in each call; may be empty.
  /// @throws BuildError if no ball fits inside the mesh.
  LevelBalls build(const BuildSettings& settings, Progress& progress, std::span<const std::vector<Ball>> start = {});

 private:
  std::vector<Ball> startFor(std::size_t spheres) const;
  CoverSearch startSearch(std::size_t spheres, std::uint64_t seed, Progress& progress) const;
  Cover newCover(std::size_t spheres, Progress& progress) const;
  void findCovers(std::span<const std::size_t> counts, Progress& progress);
  Cover coverWithin(double stand_off, std::size_t max_leaves, Progress& progress);
  LevelBalls levels(std::span<const std::size_t> counts, const Cover* leaves, Progress& progress);

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  Quality quality_ = Quality::Standard;
  std::uint64_t seed_ = 0;
  std::span<const std::vector<Ball>> start_;
  std::map<std::size_t, Cover> covers_;             // by number of spheres
  std::vector<std::optional<CoverSearch>> leaves_;  // searches of the leaves for the last tolerance
};

}  // namespace spheretree::builder
