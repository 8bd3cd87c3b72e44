// SPDX-License-Identifier: GPL-3.0-or-later
// A hierarchy of axis-aligned boxes, four children wide: the spatial index under distances, unions of balls and samples.
// Immutable after construction, so that any number of threads may search it.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace spheretree::builder {

class BoxTree {
 public:
  BoxTree() = default;
  /// Binned surface-area heuristic; O(n log n). Same boxes, same tree. Items are then addressed by *slot*: their place in the
  /// order of the leaves. Store item data in slot order, so that a leaf is one run of memory.
  explicit BoxTree(std::span<const Eigen::AlignedBox3d> boxes, int leaf_size = 4);

  /// order()[slot] is the index of the item in the span given to the constructor.
  const std::vector<std::uint32_t>& order() const { return order_; }

  /// Visits leaves nearest box first, as long as the squared distance from `p` to a box is below `limit2`, which `leaf` may
  /// lower as it goes. `leaf(first_slot, count)`.
  template <class Leaf>
  void searchNearest(const Eigen::Vector3d& p, double& limit2, Leaf&& leaf) const {
    if (nodes_.empty()) return;
    struct Entry {
      double distance2;
      std::int32_t node;
    };
    std::array<Entry, kStack> stack;
    int top = 0;
    stack[static_cast<std::size_t>(top++)] = {0.0, 0};
    while (top > 0) {
      const Entry entry = stack[static_cast<std::size_t>(--top)];
      if (!(entry.distance2 < limit2)) continue;
      const Node& node = nodes_[static_cast<std::size_t>(entry.node)];
      std::array<double, 4> d2 = distances(node, p);
      std::array<int, 4> by_distance{0, 1, 2, 3};
      const auto sort2 = [&](int a, int b) {  // a sorting network, farthest first
        if (d2[static_cast<std::size_t>(a)] < d2[static_cast<std::size_t>(b)]) {
          std::swap(d2[static_cast<std::size_t>(a)], d2[static_cast<std::size_t>(b)]);
          std::swap(by_distance[static_cast<std::size_t>(a)], by_distance[static_cast<std::size_t>(b)]);
        }
      };
      sort2(0, 1), sort2(2, 3), sort2(0, 2), sort2(1, 3), sort2(1, 2);
      // Leaves at once, nearest first, since they lower the limit; inner nodes wait on the stack, nearest on top.
      for (std::size_t i = 4; i-- > 0;) {
        const auto k = static_cast<std::size_t>(by_distance[i]);
        if (node.count[k] > 0 && d2[i] < limit2) leaf(static_cast<std::size_t>(node.child[k]), static_cast<std::size_t>(node.count[k]));
      }
      for (std::size_t i = 0; i < 4; ++i) {
        const auto k = static_cast<std::size_t>(by_distance[i]);
        if (node.count[k] < 0 && d2[i] < limit2) stack[static_cast<std::size_t>(top++)] = {d2[i], node.child[k]};
      }
    }
  }

  /// Visits every leaf whose box comes within sqrt(`radius2`) of `p` (touching counts), in a fixed order.
  template <class Leaf>
  void searchWithin(const Eigen::Vector3d& p, double radius2, Leaf&& leaf) const {
    if (nodes_.empty()) return;
    std::array<std::int32_t, kStack> stack;
    int top = 0;
    stack[static_cast<std::size_t>(top++)] = 0;
    while (top > 0) {
      const Node& node = nodes_[static_cast<std::size_t>(stack[static_cast<std::size_t>(--top)])];
      const std::array<double, 4> d2 = distances(node, p);
      for (std::size_t k = 0; k < 4; ++k) {
        if (node.count[k] == 0 || !(d2[k] <= radius2)) continue;
        if (node.count[k] > 0)
          leaf(static_cast<std::size_t>(node.child[k]), static_cast<std::size_t>(node.count[k]));
        else
          stack[static_cast<std::size_t>(top++)] = node.child[k];
      }
    }
  }

 private:
  static constexpr std::size_t kStack = 256;  // depth is at most 60 (build() balances below that), three entries a level
  struct Node {
    double low[3][4], high[3][4];
    std::int32_t child[4];  // inner: node index; leaf: first slot
    std::int32_t count[4];  // > 0: leaf with that many items; -1: inner; 0: empty
  };
  static std::array<double, 4> distances(const Node& node, const Eigen::Vector3d& p) {
    std::array<double, 4> d2{};
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < 4; ++k) {
        const double below = node.low[axis][k] - p[axis], above = p[axis] - node.high[axis][k];
        const double outside = std::max(std::max(below, above), 0.0);
        d2[k] += outside * outside;
      }
    return d2;
  }

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

}  // namespace spheretree::builder
