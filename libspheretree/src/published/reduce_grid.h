// SPDX-License-Identifier: GPL-3.0-or-later
// The points are sorted into the cells of a grid, and a ball is put round those of each cell; no medial axis ("grid").
// Paper: G. Bradshaw. Bounding volume hierarchies for level-of-detail collision handling. Thesis, Trinity College
//         Dublin, 2002.
//        Where we depart from it: docs/algorithms/published/reduce_grid.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Cubic cells in the principal axes of the region, turned by an eighth of a circle about each, and in the axes of the
/// mesh, from coarse to fine, at eight offsets; the ball of a cell is the smallest ball of its points. Keeps the grid
/// of at most `most` balls whose worst overhang is least. Cost: a few hundred passes over the points. `region.limit`
/// and `region.pool` are not used.
std::vector<FittedBall> reduceGrid(const Region& region);

}  // namespace spheretree::builder
