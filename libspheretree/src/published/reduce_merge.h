// SPDX-License-Identifier: GPL-3.0-or-later
// Merges medial balls, always the pair with the lowest cost, until few are left ("merge").
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1), 2004. Differences: docs/algorithms/published/reduce_merge.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Each point starts in the medial ball in which it lies deepest; neighbours merge (initial_clusters.h). The merged
/// ball is the best of three: the smallest ball of the joint points, and a ball about each of the two old centres.
/// Cost: O(balls log balls) merges of O(points of the two) each.
std::vector<FittedBall> reduceMerge(const Region& region);

}  // namespace spheretree::builder
