// SPDX-License-Identifier: GPL-3.0-or-later
#include "upper_levels.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "skin/build_search_tree.h"

namespace spheretree::builder {

SphereTree upperLevels(const SphereTree& tree, int levels) {
  if (levels < kMinLevels || levels > tree.levelCount())
    throw std::invalid_argument("upperLevels: " + std::to_string(levels) + " of " + std::to_string(tree.levelCount()) + " levels");
  const auto kept = static_cast<std::ptrdiff_t>(tree.level_begin[static_cast<std::size_t>(levels)]);
  const auto inner = static_cast<std::ptrdiff_t>(tree.level_begin[static_cast<std::size_t>(levels) - 1]);
  SphereTree out;
  out.branching = tree.branching;
  out.origin_mm = tree.origin_mm;
  out.provenance = tree.provenance;
  out.skin = tree.skin;
  out.cover.assign(tree.cover.begin(), tree.cover.begin() + kept);
  out.child_count.assign(tree.child_count.begin(), tree.child_count.begin() + kept);
  std::fill(out.child_count.begin() + inner, out.child_count.end(), std::uint8_t{0});
  out.statistics.assign(tree.statistics.begin(), tree.statistics.begin() + levels);
  // On the last level all nodes are leaves now, so that siblings there are in any order.
  if (!linkNodes(out)) throw std::invalid_argument("upperLevels: the tree is unsound");
  encloseDescendants(out);
  std::vector<Sphere> leaves;
  for (const std::uint32_t leaf : levelSet(out, levels - 1)) leaves.push_back(out.cover[leaf]);
  out.search = buildSearchTree(leaves);
  return out;
}

}  // namespace spheretree::builder
