// SPDX-License-Identifier: Apache-2.0
// The tops of leaves on a flat face differ by about a hundredth of the overhang, a few by a tenth, so that the hull over them has folds of
// some tenths of a degree. Deep below a fold the nearest point leaps by the depth times its angle. Where many tops lie in a plane but for
// that, bridges take them as in it.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "spheretree/core/sphere.h"

namespace spheretree::runtime {

/// Points p with normal . p = height.
struct Plane {
  Eigen::Vector3d normal;
  double height;
};

inline constexpr double kFarthestMove = 3;  // of a ball's centre, and what it grows, together, in tolerances

/// The balls, but where a face is flat moved so that their tops are: at least 8 of them that lie within `tolerance` of one of the `planes`
/// come to the height of the highest. Of planes that lean by less than 30 degrees against each other, that one counts for a ball to which
/// most tops are near. None if nothing is flat. No top rises above a face that it is near to. Deterministic. Cost: O(planes * balls).
std::vector<Sphere> levelled(std::span<const Sphere> balls, std::span<const Plane> planes, double tolerance);

}  // namespace spheretree::runtime
