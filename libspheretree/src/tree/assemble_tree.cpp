// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree/assemble_tree.h"

#include <algorithm>
#include <stdexcept>

#include "certify/overhang_bound.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {

SphereTree assembleTree(const std::vector<std::vector<Sphere>>& levels, const std::vector<std::vector<std::uint32_t>>& parents,
                        int branching) {
  if (levels.empty() || levels[0].size() != 1 || parents.size() != levels.size())
    throw std::invalid_argument("tree: level 0 must be one sphere");
  std::vector<std::vector<std::vector<std::uint32_t>>> children(levels.size());  // (level)(sphere) -> indices on the next level
  for (std::size_t level = 0; level < levels.size(); ++level) children[level].resize(levels[level].size());
  for (std::size_t level = 1; level < levels.size(); ++level) {
    if (parents[level].size() != levels[level].size()) throw std::invalid_argument("tree: a sphere without a parent");
    for (std::uint32_t i = 0; i < parents[level].size(); ++i) {
      if (parents[level][i] >= levels[level - 1].size()) throw std::invalid_argument("tree: a parent out of range");
      children[level - 1][parents[level][i]].push_back(i);
    }
  }
  // An only child that repeats its parent and has no children adds nothing: the parent becomes the leaf.
  for (std::size_t level = levels.size() - 1; level-- > 0;)
    for (std::size_t i = 0; i < levels[level].size(); ++i) {
      std::vector<std::uint32_t>& mine = children[level][i];
      if (mine.size() == 1 && children[level + 1][mine[0]].empty() && levels[level + 1][mine[0]] == levels[level][i]) mine.clear();
    }
  SphereTree tree;
  tree.branching = static_cast<std::uint8_t>(branching);
  std::vector<std::uint32_t> row{0};
  for (std::size_t level = 0; level < levels.size() && !row.empty(); ++level) {
    std::vector<std::uint32_t> next;
    for (const std::uint32_t i : row) {
      std::vector<std::uint32_t>& mine = children[level][i];
      if (mine.size() > static_cast<std::size_t>(branching)) throw std::invalid_argument("tree: a sphere with too many children");
      // Children with children of their own first, as the file format requires; otherwise in the given order.
      if (level + 1 < levels.size())
        std::stable_partition(mine.begin(), mine.end(), [&](std::uint32_t c) { return !children[level + 1][c].empty(); });
      tree.cover.push_back(levels[level][i]);
      tree.child_count.push_back(static_cast<std::uint8_t>(mine.size()));
      next.insert(next.end(), mine.begin(), mine.end());
    }
    row = std::move(next);
  }
  if (!linkNodes(tree)) throw std::invalid_argument("tree: the parents make no tree");
  encloseDescendants(tree);
  countLevels(tree);
  return tree;
}

std::vector<double> stateOverhang(const DistanceField& field, SphereTree& tree) {
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  std::vector<double> of_node;
  for (const Sphere& s : tree.cover) of_node.push_back(overhangBound(field, origin, s));
  std::vector<double> of_level;
  for (int level = 0; level < tree.levelCount(); ++level) {
    double worst = 0;
    for (const std::uint32_t node : levelSet(tree, level)) worst = std::max(worst, of_node[node]);
    tree.statistics[static_cast<std::size_t>(level)].overhang_bound = roundUp(worst);
    of_level.push_back(worst);
  }
  return of_level;
}

}  // namespace spheretree::builder
