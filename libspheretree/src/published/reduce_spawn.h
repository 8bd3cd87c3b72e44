// SPDX-License-Identifier: GPL-3.0-or-later
// Places balls one by one where they cover the most points, all with one common stand-off; no medial axis ("spawn").
// Paper: G. Bradshaw. Bounding volume hierarchies for level-of-detail collision handling. Thesis, Trinity College
//         Dublin, 2002. Differences: docs/algorithms/published/reduce_spawn.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// For a stand-off e, a pattern search over its centre places a ball with the radius clearance + e where it contains
/// the largest number of points that no ball contains yet; bisection on e. Uses at most the first 400 points of the
/// region. Cost: some ten thousand distance queries.
std::vector<FittedBall> reduceSpawn(const Region& region);

}  // namespace spheretree::builder
