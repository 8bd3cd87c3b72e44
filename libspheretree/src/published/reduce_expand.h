// SPDX-License-Identifier: GPL-3.0-or-later
// Grows all medial balls by one common stand-off and covers the region with as few of them as possible ("expand").
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1), 2004. Differences: docs/algorithms/published/reduce_expand.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Radius = clearance + stand-off for every medial ball; lazy greedy cover by newly covered points; bisection on the
/// stand-off.
/// Cost: O(balls * points) for each of about ten stand-offs. Ties go to the lower ball.
std::vector<FittedBall> reduceExpand(const Region& region);

}  // namespace spheretree::builder
