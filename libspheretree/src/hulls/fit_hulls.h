// SPDX-License-Identifier: GPL-3.0-or-later
// Covers a surface with few hulls of medial balls, none of which reaches out by more than a tolerance.
// docs/algorithms/hulls/fit_hulls.md
// Units: mm, frame of the mesh.
#pragma once

#include <vector>

#include "geometry/distance_field.h"
#include "geometry/hull.h"
#include "hulls/fit_task.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Hulls that cover `mesh`, in the order in which they were chosen. Empty if more than `max_hulls` would be needed, or
/// if the tolerance is too small for its rounding. `field`: of the solid. Deterministic for any number of threads.
/// Cost: seconds, whatever the number of hulls. @throws Cancelled.
std::vector<Hull> fitHulls(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress);

}  // namespace spheretree::builder
