// SPDX-License-Identifier: GPL-3.0-or-later
// From spheres and their parents, level by level, to one sphere-tree with bounding spheres and stated overhang.
#pragma once

#include <vector>

#include "geometry/distance_field.h"
#include "spheretree/core/sphere_tree.h"

namespace spheretree::builder {

/// The tree of the levels and parents (as in LevelBalls): breadth first, with bounding spheres and sphere counts. A
/// sphere without children becomes a leaf, and so does a sphere whose only descendants repeat it. Overhang bounds,
/// origin and provenance are not set. @throws std::invalid_argument if the parents do not make a tree.
SphereTree assembleTree(const std::vector<std::vector<Sphere>>& levels, const std::vector<std::vector<std::uint32_t>>& parents,
                        int branching);

/// Stores the proven overhang of each level in `tree`, rounded up to float, and returns it in double (levels) [mm]. The
/// origin of the tree must be set.
std::vector<double> stateOverhang(const DistanceField& field, SphereTree& tree);

}  // namespace spheretree::builder
