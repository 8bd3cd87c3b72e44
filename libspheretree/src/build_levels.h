// SPDX-License-Identifier: GPL-3.0-or-later
// The balls of each level by the builder that the settings name.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// `mesh` is to be covered; `field` is the distance from its surface. Lengths, and the tolerance of the settings, are
/// in the units of
/// `mesh`. Deterministic for any number of threads. @throws BuildError, Cancelled; std::invalid_argument for a member
/// of Combined that cannot be combined.
LevelBalls buildLevels(const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings, Progress& progress);

}  // namespace spheretree::builder
