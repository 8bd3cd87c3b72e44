// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest number of octree cells that keeps a tolerance: what the builder "octree" does with one.
// Description: docs/algorithms/published/reduce_octree.md
// Units: mm, frame of the mesh. Deterministic.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "published/build_by_regions.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// One side of a cell is halved at a time, neighbours are joined if one ball contains the pieces of both, and the
/// levels have no parents. The balls of each level cover the surface exactly. If the tolerance cannot be reached with
/// branching^(levels - 1) leaves, the leaves have the smallest overhang that the search finds for that number.
/// @pre settings.tolerance_mm > 0; the settings are in range.
/// Cost: about ten balls for each cell, three or four times that if the tolerance cannot be reached.
/// @throws Cancelled.
LevelBalls buildOctreeForTolerance(const TriangleMesh& mesh, const DistanceField& field, const PublishedSettings& settings,
                                   Progress& progress);

}  // namespace spheretree::builder
