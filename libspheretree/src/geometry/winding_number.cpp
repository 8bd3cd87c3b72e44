// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/winding_number.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kFar = 3;  // distance in radii from which a cluster is approximated by a dipole
constexpr std::uint32_t kLeaf = 8;

/// Solid angle over 4 pi. A. Van Oosterom, J. Strackee. The solid angle of a plane triangle. IEEE TBME 30(2), 1983,
/// equation 8.
double windingOf(const std::array<Vector3d, 3>& corner, const Vector3d& p) {
  const Vector3d a = corner[0] - p, b = corner[1] - p, c = corner[2] - p;
  const double la = a.norm(), lb = b.norm(), lc = c.norm();
  const double below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
  const double above = a.dot(b.cross(c));
  return above == 0 && below <= 0 ? 0 : std::atan2(above, below) / (2 * std::numbers::pi);
}

}  // namespace

WindingNumber::WindingNumber(const TriangleMesh& mesh) : order_(mesh.triangles.size()) {
  corners_.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) corners_.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)});
  std::iota(order_.begin(), order_.end(), 0u);
  if (!corners_.empty()) build(0, static_cast<std::uint32_t>(corners_.size()));
}

std::uint32_t WindingNumber::build(std::uint32_t first, std::uint32_t count) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  Node node{Vector3d::Zero(), Vector3d::Zero(), 0, first, count, 0};
  Eigen::AlignedBox3d box;
  double area = 0;
  for (std::uint32_t i = first; i < first + count; ++i) {
    const auto& [a, b, c] = corners_[order_[i]];
    const Vector3d vector = 0.5 * (b - a).cross(c - a);
    const double weight = vector.norm();
    node.area_vector += vector;
    node.centre += weight * (a + b + c) / 3;
    area += weight;
    box.extend((a + b + c) / 3);
  }
  node.centre = area > 0 ? Vector3d(node.centre / area) : Vector3d(box.center());
  for (std::uint32_t i = first; i < first + count; ++i)
    for (const Vector3d& p : corners_[order_[i]]) node.radius = std::max(node.radius, (p - node.centre).norm());
  nodes_.push_back(node);
  if (count <= kLeaf) return index;
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const auto middle = [&](std::uint32_t t) { return corners_[t][0][axis] + corners_[t][1][axis] + corners_[t][2][axis]; };
  const std::uint32_t half = count / 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + half, begin + count,
                   [&](std::uint32_t a, std::uint32_t b) { return std::pair(middle(a), a) < std::pair(middle(b), b); });
  build(first, half);
  const std::uint32_t second = build(first + half, count - half);
  nodes_[index].second_child = second;
  return index;
}

double WindingNumber::at(const Vector3d& p, std::span<const std::uint32_t> leave_out) const {
  if (nodes_.empty()) return 0;
  double sum = 0;
  std::array<std::uint32_t, 64> stack;  // the count is halved at each level: at most 32 levels
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const std::uint32_t index = stack[--top];
    const Node& node = nodes_[index];
    const Vector3d to = node.centre - p;
    const double distance = to.norm();
    if (distance > kFar * node.radius) {
      sum += node.area_vector.dot(to) / (4 * std::numbers::pi * distance * distance * distance);
    } else if (node.second_child == 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        if (std::ranges::find(leave_out, order_[i]) == leave_out.end()) sum += windingOf(corners_[order_[i]], p);
    } else {
      stack[top++] = node.second_child;
      stack[top++] = index + 1;
    }
  }
  return sum;
}

}  // namespace spheretree::builder
