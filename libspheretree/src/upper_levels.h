// SPDX-License-Identifier: GPL-3.0-or-later
// A coarser sphere-tree from a finer one: its upper levels.
#pragma once

#include "spheretree/core/sphere_tree.h"

namespace spheretree::builder {

/// The first `levels` levels of `tree` (kMinLevels .. levelCount()). The spheres of the level set of the last kept
/// level become the leaves: they cover the surface as they do in `tree`, and its proven overhang is theirs. Bounding
/// spheres and search tree are computed anew, since fewer spheres must be enclosed; skin, origin and provenance remain.
/// Cost: O(nodes * levels), times about 10. @throws std::invalid_argument if `levels` is out of range.
SphereTree upperLevels(const SphereTree& tree, int levels);

}  // namespace spheretree::builder
