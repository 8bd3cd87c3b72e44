// SPDX-License-Identifier: GPL-3.0-or-later
// A tolerance for each triangle: small where work is done, larger where the tool cannot come. Guarantees: docs/batch.md
//
// A leaf that leaves the object through a triangle of tolerance t reaches out by at most t there. The tolerance of a
// region, and that of the reached surface, must hold everywhere in it. Therefore a tolerance grows with the distance d
// from there no faster than d / 2: a point that is out by more than d / 2 is nearer to where its leaf came out. In the
// belt where the tolerance grows, a leaf that came out farther away may exceed the tolerance of the triangle below it,
// up to the tolerance of the triangle through which it came out.
// Units: mm, world frame.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A ball, or a box if `radius` is 0, in which a tolerance holds.
struct ToleranceRegion {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;  // > 0: a ball
  Eigen::AlignedBox3d box;
  double tolerance = 0;  // > 0
};

/// How far from a region it makes a tolerance of `tolerance` smaller.
double regionRange(double tolerance);

/// Tolerances of the triangles of `mesh`: `tolerance` by default; the larger of that and `unreached_tolerance` where
/// `reached` (one flag a triangle; empty: all reached) says that the tool cannot come; in a region at most the region's
/// tolerance.
/// Cost: O(triangles * (log triangles + regions)).
std::vector<double> gradedTolerance(const TriangleMesh& mesh, double tolerance, std::span<const ToleranceRegion> regions,
                                    std::span<const char> reached, double unreached_tolerance);

}  // namespace spheretree::builder
