// SPDX-License-Identifier: GPL-3.0-or-later
// Medial balls are merged, the pair that costs least first, until few are left ("merge").
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1),
//        2004. Where we depart from it: docs/algorithms/published/reduce_merge.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Every point starts in the medial ball that it lies deepest in; neighbours merge (initial_clusters.h). The merged
/// ball is the best of three: the smallest ball of the united points and a ball about either old centre.
/// Cost: O(balls log balls) merges of O(points of the two) each.
std::vector<FittedBall> reduceMerge(const Region& region);

}  // namespace spheretree::builder
