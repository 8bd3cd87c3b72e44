// SPDX-License-Identifier: Apache-2.0
#include "scene/compiled_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spheretree::runtime {

Block emptyBlock() {
  Block empty;
  std::fill_n(empty.x, 8, kFarAway);
  std::fill_n(empty.y, 8, kFarAway);
  std::fill_n(empty.z, 8, kFarAway);
  std::fill_n(empty.r, 8, 0.0f);
  return empty;
}

void put(Block& block, std::size_t lane, const Eigen::Vector3d& c, float radius) {
  block.x[lane] = static_cast<float>(c.x());
  block.y[lane] = static_cast<float>(c.y());
  block.z[lane] = static_cast<float>(c.z());
  block.r[lane] = radius;
}

std::size_t CompiledTree::byteCount() const {
  return bound.size() * sizeof(Block) + spheres.size() * sizeof(Sphere) + links.size() * sizeof(BlockLinks) +
         exact.size() * sizeof(exact[0]) + item.size() * sizeof(item[0]);
}

CompiledTree compileTree(const SearchTree& search, std::span<const Sphere> items, const Eigen::Vector3d& origin, TreeOver over) {
  CompiledTree out;
  const std::size_t blocks = 1 + search.inner.size();
  out.bound = std::vector<Block>(blocks, emptyBlock());
  out.links = std::vector<BlockLinks>(blocks);
  const bool of_leaves = over == TreeOver::Leaves;
  if (of_leaves) {
    out.spheres = std::vector<Sphere>(8 * blocks, Sphere{kFarAway, kFarAway, kFarAway, 0});
    out.exact = std::vector<std::array<double, 3>>(8 * blocks, {kFarAway, kFarAway, kFarAway});
  }
  out.item = std::vector<std::uint32_t>(8 * blocks, kNoItem);
  out.smallest_radius = std::numeric_limits<float>::infinity();

  const auto putNode = [&](std::size_t slot, const Sphere& s) {
    const std::array<double, 3> c{double{s.x} + origin.x(), double{s.y} + origin.y(), double{s.z} + origin.z()};
    const Sphere at{static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]), s.radius};
    Block& block = out.bound[slot / 8];
    block.x[slot % 8] = at.x, block.y[slot % 8] = at.y, block.z[slot % 8] = at.z, block.r[slot % 8] = at.radius;
    if (of_leaves) out.spheres[slot] = at, out.exact[slot] = c;
    return c;
  };
  std::size_t next_inner = 0;  // the root is the first child of block 0
  const auto putInner = [&](std::size_t slot) {
    const std::size_t node = next_inner++;
    putNode(slot, search.inner[node]);
    BlockLinks& links = out.links[slot / 8];
    if (slot % 8 == 0) links.first_child = static_cast<std::uint16_t>(node + 1);  // the children of node n are in block n + 1
    ++links.inner;
    const int children = search.inner_children[node] + search.item_children[node];
    links.open_priority[slot % 8] = search.inner[node].radius / static_cast<float>(children);
  };
  putInner(0);
  std::size_t next_item = 0;
  for (std::size_t node = 0; node < search.inner.size(); ++node) {
    std::size_t slot = 8 * (node + 1);
    for (std::size_t k = 0; k < search.inner_children[node]; ++k) putInner(slot++);
    for (std::size_t k = 0; k < search.item_children[node]; ++k, ++slot, ++next_item) {
      const std::size_t item = search.item.empty() ? next_item : search.item[next_item];
      const auto [x, y, z] = putNode(slot, items[item]);
      out.item[slot] = static_cast<std::uint32_t>(item);
      out.reach = std::max(out.reach, std::sqrt(x * x + y * y + z * z) + static_cast<double>(items[item].radius));
      out.smallest_radius = std::min(out.smallest_radius, items[item].radius);
    }
  }
  return out;
}

SearchTree searchTreeOf(const SphereTree& tree) {
  if (!tree.search.empty()) return tree.search;
  SearchTree out;
  if (tree.isLeaf(0)) {  // a tree that is only a root: a node around its only leaf
    out.inner.push_back(tree.cover[0]);
    out.inner_children.push_back(0);
    out.item_children.push_back(1);
    out.item.push_back(0);
    return out;
  }
  std::vector<std::uint32_t> leaf_index(tree.nodeCount(), kNoItem);
  const std::vector<std::uint32_t> leaves = levelSet(tree, tree.levelCount() - 1);
  for (std::size_t i = 0; i < leaves.size(); ++i) leaf_index[leaves[i]] = static_cast<std::uint32_t>(i);
  for (std::size_t node = 0; node < tree.nodeCount(); ++node) {  // breadth first, inner siblings first: the order of a search tree
    if (tree.isLeaf(node)) continue;
    std::uint8_t inner = 0, items = 0;
    for (std::uint32_t child = tree.first_child[node]; child < tree.first_child[node] + tree.child_count[node]; ++child) {
      if (!tree.isLeaf(child)) {
        ++inner;
      } else {
        ++items;
        out.item.push_back(static_cast<std::uint16_t>(leaf_index[child]));
      }
    }
    out.inner.push_back(sphereOf(tree, node, SphereKind::Bound));
    out.inner_children.push_back(inner);
    out.item_children.push_back(items);
  }
  return out;
}

}  // namespace spheretree::runtime
