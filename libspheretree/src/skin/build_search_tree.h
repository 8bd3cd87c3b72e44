// SPDX-License-Identifier: GPL-3.0-or-later
// The search tree over the leaves of a sphere-tree, or over the patches of its skin, which the runtime traverses. The
// bounding spheres of the sphere-tree itself also enclose the cover spheres of the inner nodes, so that a query may
// stop at any level. A search that always goes down to the items does not need that, and its spheres can be smaller.
//
// Papers: J. Goldsmith, J. Salmon. Automatic creation of object hierarchies for ray tracing. IEEE CG&A 7(5), 1987 (the
//         cost of a node is its area; an item goes to the node whose area it increases least);
//         J. Bittner, M. Hapala, V. Havran. Fast insertion-based optimization of bounding volume hierarchies. Computer
//         Graphics Forum 32(1), 2013 (nodes are removed and inserted again, the best place found by branch and bound);
//         I. Wald, C. Benthin, S. Boulos. Getting rid of packets: efficient SIMD single-ray traversal using
//         multi-branching BVHs. IRT 2008 (a binary tree is collapsed into one of higher branching).
// docs/algorithms/skin/search_tree.md
#pragma once

#include <cstddef>
#include <span>

#include "spheretree/core/search_tree.h"
#include "spheretree/core/skin.h"
#include "spheretree/core/sphere.h"

namespace spheretree::builder {

/// A search tree over items of `spheres_of_item` spheres each: item i has the spheres [i * spheres_of_item, (i + 1) *
/// spheres_of_item). Each inner sphere is the smallest one that encloses the spheres of all items below, rounded
/// outward. `item` gives the order. 1 to kMaxSearchItems items. Deterministic.
/// Cost: O(n log n) for items that are distributed like parts of a surface: 3 ms for 512 leaves, 0.3 s for 21,000
/// patches.
SearchTree buildSearchTree(std::span<const Sphere> spheres, std::size_t spheres_of_item = 1);

/// Makes the search tree over the patches of `skin`, which must have triangles, and sorts the triangles into its order.
void sortForSearch(Skin& skin);

}  // namespace spheretree::builder
