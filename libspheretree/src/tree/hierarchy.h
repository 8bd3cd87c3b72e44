// SPDX-License-Identifier: GPL-3.0-or-later
// Groups the spheres of each level under the spheres of the level above, so that the bounding spheres are small.
#pragma once

#include <span>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::builder {

/// How to treat a level with fewer spheres than its parents may have children.
enum class SpareParents {
  Omit,  ///< only as many nodes as the level below needs as parents
  Fill   ///< further nodes, whose own sphere repeats that of a child, if smaller groups lower the cost
};

/// A parent for every sphere of the levels 1 and deeper: (levels)(spheres) -> index on the level above; level 0 is
/// empty. No parent has more than `branching` children, and if the counts allow it, every parent has at least one.
/// Spheres are appended to inner levels that have too few for their children, and with SpareParents::Fill to other
/// levels.
/// `parent_count`: (levels) only the first parent_count[l] spheres of level l may have children; empty: all.
/// Bottom-up. On each level the children are cut into as many compact groups as there are parents, and each group goes
/// to the parent whose own sphere suits it best. Then children and parents are exchanged as long as this lowers the sum
/// over the groups of children * cbrt(bounding radius), an estimate of the nodes that a traversal tests. Deterministic,
/// sequential.
/// Cost: O((children + parents) * parents) a pass and level, and about 40 us a child.
/// @throws std::invalid_argument if a level has more than branching^level spheres.
std::vector<std::vector<std::uint32_t>> groupLevels(std::vector<std::vector<Sphere>>& levels, int branching,
                                                    SpareParents spare = SpareParents::Omit,
                                                    std::span<const std::size_t> parent_count = {});

/// Spheres of each level of the shallowest tree with `leaves` (>= 1) leaves: level 0 first, the leaves last. A parent
/// gets three quarters of its maximum number of children if the level above has room for that, since full groups have
/// large bounding spheres.
std::vector<std::size_t> levelCounts(std::size_t leaves, int branching);

}  // namespace spheretree::builder
