// SPDX-License-Identifier: GPL-3.0-or-later
// The balls of each level, by the builder that the settings select.
#pragma once

#include "base/ball.h"
#include "cover/build_cover.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

class LevelBuilder {
 public:
  /// Covers `mesh`; `field` is the distance from its surface. Both must outlive the builder.
  LevelBuilder(const TriangleMesh& mesh, const DistanceField& field) : mesh_(mesh), field_(field), cover_(mesh, field) {}

  /// The levels for the settings; lengths in the units of the mesh. With the builder cover, a call continues the
  /// previous one (cover/build_cover.h). The same sequence of calls gives the same balls for any number of threads.
  /// @throws BuildError, Cancelled; std::invalid_argument for a member of Combined that cannot be combined.
  LevelBalls build(const BuildSettings& settings, Progress& progress);

 private:
  const TriangleMesh& mesh_;
  const DistanceField& field_;
  CoverBuilder cover_;
};

}  // namespace spheretree::builder
