// SPDX-License-Identifier: Apache-2.0
// A tree over the leaves of a sphere-tree alone, made when a scene is loaded: what the search follows down.
// The file's bounding spheres also hold the cover spheres of the inner nodes, so that a query may stop at any level; a search that goes
// down to the leaves needs none of that. Over the leaves alone, grouped anew, it tests a third of the nodes (docs/runtime.md, Search tree).
// Papers: J. Goldsmith, J. Salmon, Automatic creation of object hierarchies for ray tracing, IEEE CG&A 7(5), 1987 (cost: members times
//         area); I. Wald, C. Benthin, S. Boulos, Getting rid of packets: efficient SIMD single-ray traversal using multi-branching BVHs,
//         IRT 2008 (of the parts so far the dearest is cut, until a node has all its children).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::runtime {

inline constexpr std::uint32_t kNotALeaf = 0xffffffffu;

struct SearchNode {
  Sphere sphere;       // a leaf as given; else the smallest ball about the leaves below [mm]
  std::uint32_t leaf;  // index among the leaves given; kNotALeaf for an inner node
  std::uint32_t first_child = 0;
  std::uint32_t child_count = 0;  // 2 to 8; 0 for a leaf
};

/// Breadth first, the root first; children are consecutive, those with children of their own ahead. At most 8191 inner nodes for up to
/// 32768 leaves (>= 1), so that 16 bits name a slot. Deterministic. Cost: O(n log n) a level, 5 ms for 512 leaves.
std::vector<SearchNode> makeSearchTree(std::span<const Sphere> leaves);

}  // namespace spheretree::runtime
