// SPDX-License-Identifier: GPL-3.0-or-later
// Balls in the slot order of a box tree over them, so that a search reads contiguous memory.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/box_tree.h"

namespace spheretree::builder {

struct BallIndex {
  BoxTree tree;
  std::vector<Ball> balls;

  /// `grow` [mm] is added to every radius; it may be negative.
  explicit BallIndex(std::span<const Ball> given, double grow = 0) {
    std::vector<Eigen::AlignedBox3d> boxes;
    boxes.reserve(given.size());
    for (const Ball& b : given) {
      const Eigen::Vector3d half = Eigen::Vector3d::Constant(std::max(0.0, b.radius + grow));
      boxes.emplace_back(b.centre - half, b.centre + half);
    }
    tree = BoxTree(boxes, 2);
    balls.reserve(given.size());
    for (const std::uint32_t i : tree.order()) balls.push_back({given[i].centre, given[i].radius + grow});
  }
  std::uint32_t original(std::uint32_t slot) const { return tree.order()[slot]; }
};

}  // namespace spheretree::builder
