// SPDX-License-Identifier: GPL-3.0-or-later
// The bounding box is halved again and again, and a ball is put round the surface in each cell ("octree").
// Paper: the baseline of P. M. Hubbard, ACM Trans. Graphics 15(3), 1996, and of G. Bradshaw's thesis, Trinity College
//         Dublin, 2002.
//        Where we depart from it: docs/algorithms/published/reduce_octree.md
// Units: mm, frame of the mesh. Deterministic.
#pragma once

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "published/build_by_regions.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A cell is halved along its three longest sides (two for a branching of 4 to 7, one for 2 and 3), the triangles in it
/// are cut at the planes, and a child stands for each part that holds any piece. Its ball holds the corners of the
/// pieces, so that the balls of a level cover the surface exactly: the smallest such ball, or one about a centre inside
/// where that reaches out less. With a tolerance, as few cells as keep it and no octants: one side is halved at a time,
/// neighbours whose joint pieces one ball holds are joined, and the levels have no parents.
/// `settings.quality` and `settings.seed` have no effect.
/// Cost: O(pieces) a level; with a tolerance, about ten balls for each cell, three or four times that if it is out of
/// reach.
/// @throws std::invalid_argument for settings out of range, Cancelled.
LevelBalls buildOctree(const TriangleMesh& mesh, const DistanceField& field, const PublishedSettings& settings, Progress& progress);

}  // namespace spheretree::builder
