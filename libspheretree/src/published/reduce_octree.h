// SPDX-License-Identifier: GPL-3.0-or-later
// Halves a cube round the mesh repeatedly; each cell that holds surface gets the ball round the cell ("octree").
// Paper: the baseline of P. M. Hubbard, ACM Trans. Graphics 15(3), 1996, and of G. Bradshaw's thesis, Trinity College
//         Dublin, 2002. Differences: docs/algorithms/published/reduce_octree.md
// Units: mm, frame of the mesh. Deterministic.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Halves a cell along its three longest sides (two for a branching of 4 to 7, one for 2 and 3), cuts its triangles at
/// the planes, and makes a child for each part that contains any piece. The ball of a cell is the one round its box, so
/// that the balls of a level cover the surface exactly. Cells whose ball keeps the tolerance are not divided. Of
/// `settings`, reads levels, branching and tolerance_mm. Cost: O(pieces) a level. @throws Cancelled.
LevelBalls buildOctree(const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings, Progress& progress);

}  // namespace spheretree::builder
