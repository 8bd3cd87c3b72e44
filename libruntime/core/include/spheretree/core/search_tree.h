// SPDX-License-Identifier: Apache-2.0
// A tree of up to 8 children over items that stand in space: the leaves of a sphere-tree, or the triangles of its skin.
// The builder makes it and stores it in the file; the runtime goes down along it to find what a tool can touch.
// Units: mm, frame of the tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/sphere.h"

namespace spheretree {

inline constexpr std::size_t kSearchBranching = 8;
/// With up to 8191 inner nodes below the root's block, 16 bits name every node.
inline constexpr std::size_t kMaxSearchNodes = 8191;
inline constexpr std::size_t kMaxSearchItems = 32768;
/// Levels of inner nodes. 5 hold the most items; the limit keeps the cost of a check in proportion to the items,
/// whatever a file says.
inline constexpr std::size_t kMaxSearchLevels = 256;

/// Inner nodes stand breadth first, the root first. The children of inner node i are, in this order, the next
/// `inner_children[i]` inner nodes and the next `item_children[i]` items that no node before it has taken; together 1
/// to 8.
struct SearchTree {
  std::vector<Sphere> inner;                 // (inner nodes) encloses all items below
  std::vector<std::uint8_t> inner_children;  // (inner nodes)
  std::vector<std::uint8_t> item_children;   // (inner nodes)
  std::vector<std::uint16_t> item;           // (items) index of each item in the order in which the nodes take them; empty: 0, 1, 2, ...

  bool empty() const { return inner.empty(); }
  friend bool operator==(const SearchTree&, const SearchTree&) = default;
};

/// First broken rule of the topology (array sizes, counts, levels, each of `items` items taken once) as a sentence, or
/// "" if there is none. What the spheres enclose is the business of whoever knows the items. Cost: O(items).
std::string findTopologyFault(const SearchTree& tree, std::size_t items);

}  // namespace spheretree
