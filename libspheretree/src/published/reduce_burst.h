// SPDX-License-Identifier: GPL-3.0-or-later
// Removes medial balls one by one and gives their points to their neighbours, until few are left ("burst").
// Paper: G. Bradshaw, C. O'Sullivan. Adaptive medial-axis approximation for sphere-tree construction. ACM Trans.
//         Graphics 23(1), 2004. Differences: docs/algorithms/published/reduce_burst.md
#pragma once

#include "published/region_reducer.h"

namespace spheretree::builder {

/// Each point of a removed ball goes to a neighbour that already contains it, otherwise to the neighbour that has to
/// grow least. The next ball to remove is the one whose removal increases the sum of the sixth powers of its
/// neighbours' overhangs least, so that the error spreads evenly.
/// Cost: O(balls^2 + balls * points of a ball and its neighbours). Ties go to the lower ball.
std::vector<FittedBall> reduceBurst(const Region& region);

}  // namespace spheretree::builder
