// SPDX-License-Identifier: GPL-3.0-or-later
// A binary tree of balls over balls or points, which finds the items that can touch something.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace spheretree::player {

struct BallTree {
  struct Node {
    Eigen::Vector3d centre;
    double radius;               // encloses all items below
    std::uint32_t first, count;  // of `order`
    std::uint32_t left;          // children: left and left + 1; 0: a leaf
  };
  std::vector<Node> nodes;           // the root first; empty: no items
  std::vector<std::uint32_t> order;  // items, in an order in which those of a node are consecutive

  BallTree() = default;
  /// Splits at the median of the longest axis until a node has at most 8 items. With empty `radii` the items are
  /// points.
  BallTree(std::span<const Eigen::Vector3d> centres, std::span<const double> radii);

  /// Calls item(i) for each item of a leaf if mayTouch(centre, radius) is true for its node and all nodes above.
  template <class MayTouch, class Item>
  void visit(MayTouch&& mayTouch, Item&& item, std::uint32_t at = 0) const {
    if (nodes.empty()) return;
    const Node& node = nodes[at];
    if (!mayTouch(node.centre, node.radius)) return;
    if (node.left != 0) {
      visit(mayTouch, item, node.left);
      visit(mayTouch, item, node.left + 1);
      return;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) item(order[i]);
  }
};

}  // namespace spheretree::player
