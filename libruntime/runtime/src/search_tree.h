// SPDX-License-Identifier: Apache-2.0
// A tree over the leaves of a sphere-tree alone, made when a scene is loaded: what the search follows down.
// The file's bounding spheres also hold the cover spheres of the inner nodes, so that a query may stop at any level; a search that goes
// down to the leaves needs none of that. Over the leaves alone, grouped anew, it tests an eighth to nearly half of the nodes
// (docs/runtime.md, Search tree).
// Papers: J. Goldsmith, J. Salmon, Automatic creation of object hierarchies for ray tracing, IEEE CG&A 7(5), 1987 (cost: area; a node
//         goes to where it adds least);
//         J. Bittner, M. Hapala, V. Havran, Fast insertion-based optimization of bounding volume hierarchies, Computer Graphics Forum
//         32(1), 2013 (nodes are taken out and put in again, the best place found by branch and bound);
//         I. Wald, C. Benthin, S. Boulos, Getting rid of packets: efficient SIMD single-ray traversal using multi-branching BVHs, IRT
//         2008 (a binary tree made into one of many children).
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
/// 32768 leaves (>= 1), so that 16 bits name a slot. Deterministic. Cost: O(n log n) for leaves as a surface has them, 2 ms for 512.
std::vector<SearchNode> makeSearchTree(std::span<const Sphere> leaves);

/// Of two nodes that touch, that with the larger one is opened: what the radius promises to rule out, for each test of a child that it
/// takes.
inline float open_priority(float radius, std::size_t child_count) { return radius / static_cast<float>(child_count); }

}  // namespace spheretree::runtime
