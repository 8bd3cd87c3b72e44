// SPDX-License-Identifier: GPL-3.0-or-later
// The largest distance of triangles from a surface: one side of the Hausdorff distance, as a proven bound. Also clips
// triangles to the part that lies outside a solid or near its surface.
// Units: mm. Deterministic for any number of threads.
#pragma once

#include <span>

#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// A proven upper bound of the distance from any point of `triangles` of `mesh` to the surface. It exceeds the largest
/// distance by at most 5 % and `sufficient_bound` [mm, > 0], except after a million pieces. Branch and bound: over a
/// piece, the distance to one triangle is largest in a corner.
double farthestFrom(const DistanceField& field, const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, double sufficient_bound,
                    Progress& progress);

struct PartsNearSurface {
  TriangleMesh pieces;  // the remaining triangles and pieces of triangles, each with vertices of its own
  // Indices of the given triangles, in their order.
  std::vector<std::uint32_t> removed;  // nothing of them is left
  std::vector<std::uint32_t> partly;   // a part of them is removed
};

/// Removes the parts of the triangles that lie deeper than `depth` [mm] within the solid. Removed parts are proven to
/// lie deeper; remaining pieces may be deeper in part. Pieces are no smaller than depth / 8.
PartsNearSurface clipToDepth(const DistanceField& solid, const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, double depth,
                             Progress& progress);

}  // namespace spheretree::builder
