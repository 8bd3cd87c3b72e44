// SPDX-License-Identifier: Apache-2.0
// The smallest ball that encloses given balls.
#pragma once

#include <span>

#include "spheretree/core/sphere.h"

namespace spheretree {

/// The smallest ball that encloses `spheres` (one or more; centres finite, radii > 0), rounded outward to float. Its
/// radius is within a factor of 1.0001 of the optimum. Deterministic. The radius is infinite if it does not fit a
/// float.
/// Method: the basis exchange of linear-type programming, with the farthest ball entering as in B. Gaertner, Fast and
///         robust smallest enclosing balls, ESA 1999; balls in place of points after K. Fischer and B. Gaertner, The
///         smallest enclosing ball of balls, SoCG 2003. Cost: O(spheres), times about 10.
Sphere smallestEnclosing(std::span<const Sphere> spheres);

/// The same in double precision, without rounding outward: the radius is the largest distance as computed, which
/// exceeds that of the optimum only by rounding, or slightly more on degenerate input. Radii >= 0. None give a ball of
/// radius 0.
Ball smallestEnclosing(std::span<const Ball> balls);
/// The same of points.
Ball smallestEnclosing(std::span<const Eigen::Vector3d> points);

}  // namespace spheretree
