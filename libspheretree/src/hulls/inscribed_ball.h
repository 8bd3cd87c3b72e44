// SPDX-License-Identifier: GPL-3.0-or-later
// Balls in a solid below points of its surface. They are as large as their distance from the surface.
// docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include <Eigen/Core>

#include "base/ball.h"
#include "geometry/distance_field.h"

namespace spheretree::builder {

inline constexpr double kFirstMove = 0.3;  // first step of a ball that is moved, as a share of its radius
inline constexpr double kThinnest = 0.05;  // distance from a line, as a share of a length along it, that counts as one

/// The deepest ball below a point of the surface that leaves at most `gap` > 0 between them; radius 0 if there is none.
/// `normal`: unit, outward. Balls that touch the surface would be far smaller below flat facets than the surface is
/// thick.
Ball ballBelow(const DistanceField& field, const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double gap);

/// The ball, moved to where the surface is farther away, but not farther than `gap` from the point: a long cone is
/// within the tolerance only if it is centred. Of balls of one size, the one nearest to the point, so that borders are
/// reached.
Ball centred(const DistanceField& field, Ball ball, const Eigen::Vector3d& point, double gap);

/// Perpendicular directions: `unit`; then towards `other`, if that is farther than `shortest` across the former; then
/// across both.
Eigen::Matrix3d axesFrom(const Eigen::Vector3d& unit, const Eigen::Vector3d& other, double shortest);

}  // namespace spheretree::builder
