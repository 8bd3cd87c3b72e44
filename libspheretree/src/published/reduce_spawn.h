// SPDX-License-Identifier: GPL-3.0-or-later
// Balls are placed one by one where they cover most, all with one common stand-off; no medial axis ("spawn").
// Paper: G. Bradshaw. Bounding volume hierarchies for level-of-detail collision handling. Thesis, Trinity College
//         Dublin, 2002.
//        Where we depart from it: docs/algorithms/published/reduce_spawn.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// For a stand-off e, a ball is placed by a pattern search over its centre, its radius the clearance plus e, to hold
/// the most points that no ball holds yet; bisection on e. Uses at most the first 400 points of the region.
/// Cost: some ten thousand distance queries.
std::vector<FittedBall> reduceSpawn(const Region& region);

}  // namespace spheretree::builder
