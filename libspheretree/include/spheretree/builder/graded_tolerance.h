// SPDX-License-Identifier: GPL-3.0-or-later
// A tolerance for each triangle: small where work is done, larger where the tool cannot come. What it guarantees:
// docs/batch.md
//
// A leaf that leaves the object through a triangle of tolerance t reaches out by at most t there. So that the tolerance
// of a region, and that of what is reached, holds in all of it, a tolerance grows with the distance d from there no
// faster than d / 2: a point that is out by more than d / 2 is nearer to where its leaf came out. In the belt where it
// grows, a leaf that came out farther off may reach out by more than the triangle below says, up to its own.
// Units: mm, world frame.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A ball, or a box if `radius` is 0, whose tolerance holds in it.
struct ToleranceRegion {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;  // > 0: a ball
  Eigen::AlignedBox3d box;
  double tolerance = 0;  // > 0
};

/// Tolerances of the triangles of `mesh`: `tolerance` where nothing else is said; `unreached_tolerance`, if more, where
/// `reached` (one a triangle, or empty: all) says that the tool cannot come; in a region at most the region's.
/// Cost: O(triangles * (log triangles + regions)).
std::vector<double> gradedTolerance(const TriangleMesh& mesh, double tolerance, std::span<const ToleranceRegion> regions,
                                    std::span<const char> reached, double unreached_tolerance);

}  // namespace spheretree::builder
