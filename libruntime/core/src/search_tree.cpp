// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/search_tree.h"

#include "search_tree_spheres.h"

namespace spheretree {

std::string findTopologyFault(const SearchTree& tree, std::size_t items) {
  const std::size_t inner = tree.inner.size();
  if (inner == 0) return "the search tree has no root";
  if (inner > kMaxSearchNodes || items > kMaxSearchItems)
    return "the search tree has " + std::to_string(inner) + " inner nodes over " + std::to_string(items) + " items; at most " +
           std::to_string(kMaxSearchNodes) + " and " + std::to_string(kMaxSearchItems);
  if (tree.inner_children.size() != inner || tree.item_children.size() != inner)
    return "the search tree has " + std::to_string(inner) + " inner nodes, but other numbers of child counts";
  std::size_t next_inner = 1, next_item = 0, levels = 0;
  for (std::size_t i = 0, level_end = 0; i < inner; ++i) {
    if (i == level_end) {
      level_end = next_inner;
      if (++levels > kMaxSearchLevels) return "the search tree has more than " + std::to_string(kMaxSearchLevels) + " levels";
    }
    const std::size_t children = std::size_t{tree.inner_children[i]} + tree.item_children[i];
    if (children < 1 || children > kSearchBranching)
      return "node " + std::to_string(i) + " of the search tree has " + std::to_string(children) + " children, not 1 to 8";
    next_inner += tree.inner_children[i];
    next_item += tree.item_children[i];
    if (next_inner > inner || next_inner <= i + (i + 1 < inner ? 1 : 0))
      return "node " + std::to_string(i) + " of the search tree: the counts of children do not make one tree";
  }
  if (next_inner != inner || next_item != items)
    return "the search tree holds " + std::to_string(next_item) + " of " + std::to_string(items) + " items";
  if (tree.item.empty()) return {};
  if (tree.item.size() != items)
    return "the search tree orders " + std::to_string(tree.item.size()) + " of " + std::to_string(items) + " items";
  std::vector<bool> taken(items, false);
  for (const std::uint16_t item : tree.item) {
    if (item >= items || taken[item]) return "item " + std::to_string(item) + " of the search tree is out of range or taken twice";
    taken[item] = true;
  }
  return {};
}

std::string describeSphereFault(std::size_t node, std::size_t item) {
  const std::string sphere = "sphere " + std::to_string(node) + " of the search tree";
  return item == kNoItem ? sphere + " is not finite, or its radius is not above 0"
                         : sphere + " does not enclose item " + std::to_string(item);
}

}  // namespace spheretree
