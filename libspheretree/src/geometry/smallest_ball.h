// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest ball that holds a set of points.
#pragma once

#include <span>

#include "base/ball.h"

namespace spheretree::builder {

/// Pivoting on the farthest point, with at most four points of support solved exactly. Paper: B. Gaertner. Fast and
/// robust smallest enclosing balls. ESA 1999. The radius holds every point; it exceeds the least by rounding only, or,
/// should the pivoting run into its step limit on degenerate input, by little. Radius 0 for one point; {0, 0} for none.
/// Cost: O(points) for each of about ten pivots.
Ball smallestBall(std::span<const Eigen::Vector3d> points);

/// Centre of the sphere through four points. Not finite, or far off, for a flat tetrahedron.
Eigen::Vector3d circumcentre(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, const Eigen::Vector3d& d);

}  // namespace spheretree::builder
