// SPDX-License-Identifier: GPL-3.0-or-later
// Sorts the points into the cells of a grid and encloses the points of each cell in a ball; no medial axis ("grid").
// Paper: G. Bradshaw. Bounding volume hierarchies for level-of-detail collision handling. Thesis, Trinity College
//         Dublin, 2002. Differences: docs/algorithms/published/reduce_grid.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Tries cubic cells from coarse to fine, at eight offsets, in these axes: the principal axes of the region, the same
/// rotated by 45 degrees about each axis, and the axes of the mesh. The ball of a cell is the smallest ball of its
/// points. Keeps the grid of at most `max_balls` balls whose worst overhang is smallest. Cost: a few hundred passes
/// over the points. `region.pool` is not used.
std::vector<FittedBall> reduceGrid(const Region& region);

}  // namespace spheretree::builder
