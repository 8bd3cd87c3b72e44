// SPDX-License-Identifier: Apache-2.0
// Finds the pairs (one leaf of the tool and one leaf or triangle of an object) whose gap is at most a margin.
// Paper: D. Wang, X. Zhang, Y. Zhang, J. Xiao. Configuration-based optimization for six degree-of-freedom haptic
//         rendering using sphere-trees. IROS 2011, Algorithm 1. Differences: trees of unequal depth and roots that are
//         leaves lose no pair; of two nodes only one is opened, which halves the tests; the search is breadth first, so
//         that when a list is full, the nodes that are not opened yet replace everything below them.
#pragma once

#include <cstdint>

#include "spheretree/core/rigid.h"
#include "state/pair_set.h"

namespace spheretree::runtime {

struct StepMemory;

enum class PairsOf {
  LeavesExactly,   // pairs of leaves, exactly the set that double arithmetic gives, as the published algorithm needs it
  ContactSurface,  // skin or leaves of each object, whichever the tool rests on; includes all pairs within the margin, and possibly some
                   // beyond it
};

/// The pairs of the whole scene with gap <= `margin` [mm, >= 0], with the tool at `pose`, using at most `max_work`
/// 8-lane tests. They are stored in `memory` until the next search. The order is deterministic: by object, then in the
/// order of the search. Cost: a sphere test for each object, then about one 8-lane test for each pair. No allocation.
PairSet findPairs(const Configuration& pose, double margin, PairsOf of, std::uint32_t max_work, StepMemory& memory) noexcept;

}  // namespace spheretree::runtime
