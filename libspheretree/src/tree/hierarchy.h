// SPDX-License-Identifier: GPL-3.0-or-later
// Groups the spheres of each level under the spheres of the level above, so that the bounding spheres are small.
#pragma once

#include <span>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::builder {

/// What becomes of a level with fewer spheres than its parents may have children.
enum class SpareParents {
  Omit,  ///< as few nodes as the level below needs as parents
  Fill   ///< further nodes, whose own sphere repeats one of a child, if smaller groups pay for them
};

/// A parent for every sphere of the levels 1 and deeper: (levels)(spheres) -> index on the level above, level 0 empty.
/// No parent has more than `branching` children and, as far as the counts allow, none has none. Spheres are appended to
/// inner levels that have too few for their children, and with SpareParents::Fill to others.
/// `parent_count`: (levels) how many spheres of a level, its first, may have children; empty: all.
/// Bottom-up; on each level the children are cut into as many compact groups as there are parents, each group goes to
/// the parent whose own sphere it goes with best, and then children and parents are exchanged as long as the sum over
/// the groups of children x cube root of the bounding radius falls, which stands for the nodes that a traversal tests.
/// Deterministic, sequential.
/// Cost: O((children + parents) * parents) a pass and level, and about 40 us a child. @throws std::invalid_argument if
/// a level has more than branching^level spheres.
std::vector<std::vector<std::uint32_t>> groupLevels(std::vector<std::vector<Sphere>>& levels, int branching,
                                                    SpareParents spare = SpareParents::Omit,
                                                    std::span<const std::size_t> parent_count = {});

/// Spheres of each level of the shallowest tree with `leaves` (>= 1) leaves: level 0 first, the leaves last. A parent
/// has three quarters of the children that it may have where the level above has room for that, since full groups are
/// wide ones.
std::vector<std::size_t> levelCounts(std::size_t leaves, int branching);

}  // namespace spheretree::builder
