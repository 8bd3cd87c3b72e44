// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>

namespace spheretree::builder {

/// Centre of the sphere through four points. For a flat tetrahedron the result is not finite, or very far away.
inline Eigen::Vector3d circumcentre(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
                                    const Eigen::Vector3d& d) {
  const Eigen::Vector3d u = b - a, v = c - a, w = d - a;
  const Eigen::Vector3d vw = v.cross(w), wu = w.cross(u), uv = u.cross(v);
  const double denominator = 2 * u.dot(vw);
  return a + (u.squaredNorm() * vw + v.squaredNorm() * wu + w.squaredNorm() * uv) / denominator;
}

}  // namespace spheretree::builder
