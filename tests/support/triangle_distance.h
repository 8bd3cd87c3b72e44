// SPDX-License-Identifier: Apache-2.0
// Distance of a point from a triangle, by a slow and simple method.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace spheretree::test {

inline double distanceToTriangle(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& corners) {
  const Eigen::Vector3d normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  bool is_over = true;
  double smallest = (p - corners[0]).norm();
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d &a = corners[k], side = corners[(k + 1) % 3] - a;
    is_over = is_over && normal.dot(side.cross(p - a)) >= 0;
    const double along = std::clamp((p - a).dot(side) / side.squaredNorm(), 0.0, 1.0);
    smallest = std::min(smallest, (p - a - along * side).norm());
  }
  return is_over ? std::abs(normal.dot(p - corners[0])) : smallest;
}

}  // namespace spheretree::test
