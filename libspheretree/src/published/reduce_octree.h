// SPDX-License-Identifier: GPL-3.0-or-later
// Halves the bounding box repeatedly and encloses the surface in each cell in a ball ("octree").
// Paper: the baseline of P. M. Hubbard, ACM Trans. Graphics 15(3), 1996, and of G. Bradshaw's thesis, Trinity College
//         Dublin, 2002. Differences: docs/algorithms/published/reduce_octree.md
// Units: mm, frame of the mesh. Deterministic.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "published/build_by_regions.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Halves a cell along its three longest sides (two for a branching of 4 to 7, one for 2 and 3), cuts its triangles at
/// the planes, and makes a child for each part that contains any piece. The ball of a cell contains the corners of its
/// pieces, so that the balls of a level cover the surface exactly. It is the smallest such ball, or one about a centre
/// inside the solid, if that has a smaller overhang.
/// With a tolerance: buildOctreeForTolerance() (octree_for_tolerance.h).
/// `settings.quality` and `settings.seed` have no effect.
/// Cost: O(pieces) a level.
/// @throws std::invalid_argument for settings out of range, Cancelled.
LevelBalls buildOctree(const TriangleMesh& mesh, const DistanceField& field, const PublishedSettings& settings, Progress& progress);

}  // namespace spheretree::builder
