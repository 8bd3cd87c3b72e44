// SPDX-License-Identifier: GPL-3.0-or-later
// Medial balls are burst one by one, their points handed to the neighbours, until few are left ("burst").
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1),
//        2004. Where we depart from it: docs/algorithms/published/reduce_burst.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// A burst ball hands each point to a neighbour that holds it already, else to the one that grows least. The next to
/// burst is the one whose loss raises the sum of the sixth powers of its neighbours' overhangs least, so that error
/// spreads evenly.
/// Cost: O(balls^2 + balls * points of a ball and its neighbours). Ties go to the lower ball. `region.limit` is not
/// used.
std::vector<FittedBall> reduceBurst(const Region& region);

}  // namespace spheretree::builder
