// SPDX-License-Identifier: GPL-3.0-or-later
// Neighbouring medial balls are merged into the smallest ball of their points ("Hubbard").
// Paper: P. M. Hubbard. Approximating polyhedra with spheres for time-critical collision detection. ACM Trans. Graphics
//         15(3), 1996.
//        Where we depart from it: docs/algorithms/published/reduce_hubbard.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Every point starts in the medial ball that it lies deepest in; the two neighbours whose merged ball reaches out
/// least merge first (initial_clusters.h). The merged ball is the smallest ball of the united points, its overhang is
/// bounded by the exact distance.
/// Cost: O(balls log balls) merges of O(points of the two) each.
std::vector<FittedBall> reduceHubbard(const Region& region);

}  // namespace spheretree::builder
