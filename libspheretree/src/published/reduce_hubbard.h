// SPDX-License-Identifier: GPL-3.0-or-later
// Merges neighbouring medial balls into the smallest ball of their points ("Hubbard").
// Paper: P. M. Hubbard. Approximating polyhedra with spheres for time-critical collision detection. ACM Trans. Graphics
//         15(3), 1996. Differences: docs/algorithms/published/reduce_hubbard.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Each point starts in the medial ball in which it lies deepest; the two neighbours whose merged ball has the smallest
/// overhang merge first (initial_clusters.h). The merged ball is the smallest ball of the joint points; its overhang is
/// bounded by the exact distance.
/// Cost: O(balls log balls) merges of O(points of the two) each.
std::vector<FittedBall> reduceHubbard(const Region& region);

}  // namespace spheretree::builder
