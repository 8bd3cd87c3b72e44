// SPDX-License-Identifier: GPL-3.0-or-later
// Covers a surface with few hulls of medial balls, none of which reaches out by more than a tolerance.
// docs/algorithms/hulls/fit_hulls.md
// Units: mm, frame of the mesh.
#pragma once

#include <cstddef>
#include <vector>

#include "geometry/distance_field.h"
#include "geometry/hull.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct FitSettings {
  double tolerance = 0;       // > 0: of the overhang [mm]
  double rounding = 0;        // share of the tolerance that is left for rounding the hulls [mm]
  std::size_t max_hulls = 0;  // 1 or more
};

/// Hulls that cover `mesh`, in the order in which they were chosen. Empty if more than `max_hulls` would be needed, or
/// if the tolerance is too small for its rounding. `field`: of the solid. Deterministic for any number of threads.
/// Cost: seconds, whatever the number of hulls. @throws Cancelled.
std::vector<Hull> fitHulls(const TriangleMesh& mesh, const DistanceField& field, const FitSettings& settings, Progress& progress);

}  // namespace spheretree::builder
