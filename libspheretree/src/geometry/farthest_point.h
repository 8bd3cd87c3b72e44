// SPDX-License-Identifier: GPL-3.0-or-later
// How far triangles lie from a surface, at most: one side of the Hausdorff distance, as a proven bound. And what of
// them lies outside a solid.
// Units: mm. Deterministic for any number of threads.
#pragma once

#include <span>

#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// An upper bound of the distance from any point of `triangles` of `mesh` to the surface, by at most 5 % and `sufficient_bound`
/// [mm, > 0] above the largest, more only after a million pieces. By branch and bound: over a piece, the distance to
/// one triangle is largest in a corner.
double farthestFrom(const DistanceField& field, const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, double sufficient_bound,
                    Progress& progress);

struct PartsNearSurface {
  TriangleMesh pieces;                      // what is kept: triangles and pieces of triangles, each with vertices of its own
  std::vector<std::uint32_t> gone, partly;  // of the triangles given, in their order: nothing, or not all, is kept
};

/// The triangles, or pieces of them, without what lies deeper than `depth` [mm] within the solid. What is left out is
/// proven to lie deeper; what is kept may be deep in part. Pieces are no smaller than an eighth of `depth`.
PartsNearSurface clipToDepth(const DistanceField& solid, const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, double depth,
                             Progress& progress);

}  // namespace spheretree::builder
