// SPDX-License-Identifier: Apache-2.0
// A tree with up to 8 children a node over items in space: the leaves of a sphere-tree, or the triangles of its skin.
// The builder makes it and stores it in the file; the runtime traverses it to find what a tool can touch.
// Units: mm, frame of the tree.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "spheretree/core/sphere.h"

namespace spheretree {

inline constexpr std::size_t kSearchBranching = 8;
/// With at most 8191 inner nodes below the root's block, 16 bits can name every node.
inline constexpr std::size_t kMaxSearchNodes = 8191;
inline constexpr std::size_t kMaxSearchItems = 32768;
/// Levels of inner nodes. 5 levels suffice for kMaxSearchItems. The limit keeps the cost of checking a file
/// proportional to its number of items.
inline constexpr std::size_t kMaxSearchLevels = 256;

/// Inner nodes are stored breadth first, the root first. The children of inner node i are, in this order, the next
/// `inner_children[i]` inner nodes and the next `item_children[i]` items that no earlier node has taken. A node has 1
/// to 8 children.
struct SearchTree {
  std::vector<Sphere> inner;                 // (inner nodes) encloses all items below
  std::vector<std::uint8_t> inner_children;  // (inner nodes)
  std::vector<std::uint8_t> item_children;   // (inner nodes)
  std::vector<std::uint16_t> item;           // (items) index of each item, in the order in which the nodes take them; empty: 0, 1, 2, ...

  bool empty() const { return inner.empty(); }
  friend bool operator==(const SearchTree&, const SearchTree&) = default;
};

/// Returns a sentence about the first broken rule of the topology (array sizes, counts, levels, each of `items` items
/// taken once), or "" if there is none. It does not know the items, so the caller has to check that the spheres enclose
/// them. Cost: O(items).
std::string findTopologyFault(const SearchTree& tree, std::size_t items);

}  // namespace spheretree
