// SPDX-License-Identifier: GPL-3.0-or-later
// The balls of each level, by the builder that the settings select.
#pragma once

#include <vector>

#include "base/ball.h"
#include "cover/build_cover.h"
#include "geometry/distance_field.h"
#include "published/region_reducer.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// The published method that builds by regions. @throws std::invalid_argument for Cover, Octree and Combined.
Method methodOf(BuilderKind kind);

inline const std::vector<BuilderKind> kUsualMembers{BuilderKind::Expand, BuilderKind::Merge, BuilderKind::Burst};  // of Combined

class LevelBuilder {
 public:
  /// Covers `mesh`; `field` is the distance from its surface. Both must outlive the builder.
  LevelBuilder(const TriangleMesh& mesh, const DistanceField& field) : mesh_(mesh), field_(field), cover_(mesh, field) {}

  /// The levels for the settings; lengths in the units of the mesh. If the settings search, a call continues the
  /// previous one (cover/build_cover.h); a search for a published builder starts from the tree of the first call. The
  /// same sequence of calls gives the same balls for any number of threads.
  /// @throws BuildError, Cancelled; std::invalid_argument for a member of Combined that cannot be combined.
  LevelBalls build(const BuildSettings& settings, Progress& progress);

 private:
  LevelBalls published(const BuildSettings& settings, Progress& progress) const;

  const TriangleMesh& mesh_;
  const DistanceField& field_;
  CoverBuilder cover_;
  LevelBalls start_;  // of the search
};

}  // namespace spheretree::builder
