// SPDX-License-Identifier: GPL-3.0-or-later
// Moves the centre of one ball to where it covers its patch with the least stand-off.
#pragma once

#include <span>

#include "geometry/distance_field.h"

namespace spheretree::builder {

/// Stand-off of a ball about `centre` that covers `patch`: how far it must grow beyond the largest inscribed ball [mm].
struct Refit {
  Eigen::Vector3d centre;
  double clearance;        // distance from the centre to the surface, negative if it is outside [mm]
  double stand_off;        // max |p - centre| - clearance over the patch [mm]
  std::uint64_t work = 0;  // triangles and patch points looked at
};

/// Distance from `centre` to the farthest of `points`; 0 if there are none [mm].
double farthest(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre);

/// Minimises max over p in `patch` of |p - c|, less d(c): a difference of two maxima, not smooth and not convex.
/// Descent along the shortest vector of the epsilon-subdifferential, which is the difference of two convex hulls (unit
/// vectors from the farthest patch points, unit vectors from the nearest surface points seen so far), with a step that
/// shrinks; never worse than the start.
/// Method: C. Lemarechal's epsilon-steepest descent, with E. Gilbert's algorithm (SIAM J. Control 4(1), 1966) for the
/// shortest vector. In a solid thinner than the stand-off the best centre may lie a little outside. Stops early once
/// the stand-off is at most
/// `target`. Cost: one distance query and one pass over the patch for each of at most `most_steps` steps.
Refit refitBall(const DistanceField& field, std::span<const Eigen::Vector3d> patch, const Eigen::Vector3d& start, double clearance,
                double first_step, int most_steps, double target = 0);

}  // namespace spheretree::builder
