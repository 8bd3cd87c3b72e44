// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/search_tree.h"

#include "describe.h"

namespace spheretree {

std::string findTopologyFault(const SearchTree& tree, std::size_t items) {
  const std::size_t inner = tree.inner.size();
  if (inner == 0) return "the search tree has no root";
  if (inner > kMaxSearchNodes || items > kMaxSearchItems)
    return describe("the search tree has %zu inner nodes over %zu items; at most %zu and %zu", inner, items, kMaxSearchNodes,
                    kMaxSearchItems);
  if (tree.inner_children.size() != inner || tree.item_children.size() != inner)
    return describe("the search tree has %zu inner nodes, but other numbers of child counts", inner);
  std::size_t next_inner = 1, next_item = 0, levels = 0;
  for (std::size_t i = 0, level_end = 0; i < inner; ++i) {
    if (i == level_end) {
      level_end = next_inner;
      if (++levels > kMaxSearchLevels) return describe("the search tree has more than %zu levels", kMaxSearchLevels);
    }
    const std::size_t children = std::size_t{tree.inner_children[i]} + tree.item_children[i];
    if (children < 1 || children > kSearchBranching)
      return describe("node %zu of the search tree has %zu children, not 1 to 8", i, children);
    next_inner += tree.inner_children[i];
    next_item += tree.item_children[i];
    if (next_inner > inner || next_inner <= i + (i + 1 < inner ? 1 : 0))
      return describe("node %zu of the search tree: the counts of children do not make one tree", i);
  }
  if (next_item != items) return describe("the search tree holds %zu of %zu items", next_item, items);
  if (tree.item.empty()) return {};
  if (tree.item.size() != items) return describe("the search tree orders %zu of %zu items", tree.item.size(), items);
  std::vector<bool> taken(items, false);
  for (const std::uint16_t item : tree.item) {
    if (item >= items || taken[item]) return describe("item %u of the search tree is out of range or taken twice", unsigned{item});
    taken[item] = true;
  }
  return {};
}

}  // namespace spheretree
