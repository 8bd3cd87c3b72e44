// SPDX-License-Identifier: GPL-3.0-or-later
// Paths of a burr, and a plain judge of what they sweep.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "cut/swept_burr.h"
#include "support/random.h"

namespace spheretree::builder::test_paths {

using Eigen::Vector3d;

/// Depth in the swept space, negative outside.
inline double depthIn(std::span<const BurrPath> paths, const Vector3d& p) {
  double depth = -1e9;
  for (const BurrPath& path : paths)
    for (std::size_t k = 0; k + 1 < path.centres.size(); ++k)
      depth = std::max(depth, path.radius - (p - nearestOnAxis({path.centres[k], path.centres[k + 1], path.radius}, p)).norm());
  return depth;
}

/// A path that wanders in the box.
inline BurrPath wanderingPath(test::Random& random, double radius, const Vector3d& low, const Vector3d& high, int steps) {
  BurrPath path{radius, {}};
  Vector3d p, way;
  for (int k = 0; k < 3; ++k) p[k] = random.between(low[k], high[k]), way[k] = random.between(-0.1, 0.1);
  for (int i = 0; i <= steps; ++i) {
    path.centres.push_back(p);
    for (int k = 0; k < 3; ++k) {
      way[k] = 0.9 * way[k] + random.between(-0.03, 0.03);
      p[k] = std::clamp(p[k] + way[k], low[k], high[k]);
    }
  }
  return path;
}

}  // namespace spheretree::builder::test_paths
