// SPDX-License-Identifier: Apache-2.0
// Groups of 8 spheres, groups of 8 groups, and so on: to find those that touch a ball, and as the tree that the search follows.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "spheretree/core/sphere.h"
#include "spheretree/runtime/bridge.h"

namespace spheretree::runtime {

class SphereGroups {
 public:
  SphereGroups() = default;
  /// At most 2^18 spheres. Cost: O(n log n).
  explicit SphereGroups(std::span<const Sphere> spheres);

  /// Calls `found(index)` for each sphere that touches the ball, in the order of the tree, which is always the same.
  template <class Found>
  void visit(const Eigen::Vector3d& centre, double radius, const Found& found) const {
    if (!levels_.empty()) visit(centre, radius, levels_.size() - 1, 0, found);
  }

  const std::vector<std::uint32_t>& order() const { return order_; }          // index of each sphere of the lowest level
  const std::vector<std::vector<Sphere>>& levels() const { return levels_; }  // from the spheres up to one that holds all

 private:
  template <class Found>
  void visit(const Eigen::Vector3d& centre, double radius, std::size_t level, std::size_t at, const Found& found) const {
    const Sphere& s = levels_[level][at];
    const double reach = radius + static_cast<double>(s.radius);
    if ((centre - Eigen::Vector3d(s.x, s.y, s.z)).squaredNorm() > reach * reach) return;
    if (level == 0) {
      found(order_[at]);
      return;
    }
    const std::size_t end = std::min(levels_[level - 1].size(), 8 * at + 8);
    for (std::size_t k = 8 * at; k < end; ++k) visit(centre, radius, level - 1, k, found);
  }

  std::vector<std::uint32_t> order_;
  std::vector<std::vector<Sphere>> levels_;
};

/// `around[i]` holds all of `bridges[i]`. At most kMostBridges.
BridgeTree treeOf(std::span<const Bridge> bridges, std::span<const Sphere> around);

}  // namespace spheretree::runtime
