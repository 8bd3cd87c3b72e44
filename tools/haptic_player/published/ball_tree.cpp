// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/ball_tree.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>

namespace spheretree::player {

constexpr std::uint32_t kLeafItems = 8;

BallTree::BallTree(std::span<const Eigen::Vector3d> centres, std::span<const double> radii) {
  order.resize(centres.size());
  std::iota(order.begin(), order.end(), 0u);
  if (order.empty()) return;
  nodes.push_back({Eigen::Vector3d::Zero(), 0, 0, static_cast<std::uint32_t>(order.size()), 0});
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const std::uint32_t first = nodes[n].first, count = nodes[n].count;
    const std::span<std::uint32_t> items(order.data() + first, count);
    Eigen::AlignedBox3d box;
    for (const std::uint32_t i : items) box.extend(centres[i]);
    double radius = 0;
    for (const std::uint32_t i : items) radius = std::max(radius, (centres[i] - box.center()).norm() + (radii.empty() ? 0 : radii[i]));
    nodes[n].centre = box.center();
    nodes[n].radius = radius;
    if (count <= kLeafItems) continue;
    Eigen::Index axis;
    box.sizes().maxCoeff(&axis);
    const std::uint32_t half = count / 2;
    std::nth_element(items.begin(), items.begin() + half, items.end(), [&](std::uint32_t a, std::uint32_t b) {
      return centres[a][axis] != centres[b][axis] ? centres[a][axis] < centres[b][axis] : a < b;
    });
    nodes[n].left = static_cast<std::uint32_t>(nodes.size());
    nodes.push_back({Eigen::Vector3d::Zero(), 0, first, half, 0});
    nodes.push_back({Eigen::Vector3d::Zero(), 0, first + half, count - half, 0});
  }
}

}  // namespace spheretree::player
