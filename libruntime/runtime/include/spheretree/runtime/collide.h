// SPDX-License-Identifier: Apache-2.0
// Finds the pairs of leaves, one of the tool and one of an object, whose gap is at most a margin.
// Paper: D. Wang, X. Zhang, Y. Zhang, J. Xiao. Configuration-based optimization for six degree-of-freedom haptic rendering using
//        sphere-trees. IROS 2011, Algorithm 1. Departures: trees of unequal depth and roots that are leaves lose no pair; of two nodes
//        only one is opened, which halves the tests; the search is breadth first over all objects, so that when a list is full what is
//        still to open stands for the rest of the scene.
#pragma once

#include <cstdint>
#include <span>

#include "spheretree/core/rigid.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

class Workspace;

/// Which arithmetic runs the inner loops. All give the same bits.
enum class Kernel { Best, Scalar, Avx2 };

/// True if this machine can run `kernel`.
bool isAvailable(Kernel kernel);

/// Consecutive pairs of one object, or of one of Scene::bridges. Pair: tool slot << 16 | object slot.
struct PairRun {
  std::uint32_t object, begin, count;
};

struct PairSet {
  std::span<const std::uint32_t> pairs;
  std::span<const PairRun> runs;
  bool coarse = false;     // the lists or the work ran out: some pairs are inner nodes, whose balls stand for the leaves in them
  std::uint32_t work = 0;  // 8-lane tests done
};

/// The pairs of the whole scene, tool at `pose`, gap <= `margin` [mm, >= 0], with at most `max_work` 8-lane tests. Held by `workspace`
/// until the next search. `exact`: the set that double arithmetic gives, pair by pair; otherwise some pairs beyond the margin, by float
/// rounding, may be among them, and none within is missed. Order: by object, then as the search meets them; always the same. Cost: a sphere
/// test for each object, then about one 8-lane test for each pair. No allocation.
PairSet findPairs(const Scene& scene, const Configuration& pose, double margin, bool exact, std::uint32_t max_work,
                  Workspace& workspace) noexcept;

/// Leaves of the tool with the bridges that they may touch before they have moved by `margin` [mm]: all of them, and others nearby; not all
/// if `coarse`. Held by `workspace` until the next such search; the pairs of leaves stay. Order and cost as above. No allocation.
PairSet findBridges(const Scene& scene, const Configuration& pose, double margin, std::uint32_t max_work, Workspace& workspace) noexcept;

}  // namespace spheretree::runtime
