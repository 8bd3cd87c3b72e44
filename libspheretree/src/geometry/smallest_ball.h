// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest ball that contains a set of points.
#pragma once

#include <span>

#include "base/ball.h"

namespace spheretree::builder {

/// Pivots on the farthest point; at most four support points are solved exactly. Paper: B. Gaertner. Fast and robust
/// smallest enclosing balls. ESA 1999. The ball contains every point. Its radius exceeds the smallest one only by
/// rounding, or slightly more if the pivoting reaches its step limit on degenerate input. Radius 0 for one point; {0,
/// 0} for none. Cost: O(points) for each of about ten pivots.
Ball smallestBall(std::span<const Eigen::Vector3d> points);

/// Centre of the sphere through four points. For a flat tetrahedron the result is not finite, or very far away.
Eigen::Vector3d circumcentre(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);

}  // namespace spheretree::builder
