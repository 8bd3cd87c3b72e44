// SPDX-License-Identifier: GPL-3.0-or-later
// Moves the centre of one ball to where it covers its patch with the smallest stand-off.
#pragma once

#include <span>

#include "geometry/distance_field.h"

namespace spheretree::builder {

/// First step of a refit, as a share of the width of the patch that the ball covers.
inline constexpr double kFirstStepShare = 0.2;

inline constexpr int kCoverRefitSteps = 14;  // of a refit in the search for a cover

/// The stand-off of a ball about `centre` that covers `patch`: its radius minus the radius of the inscribed ball about
/// the same centre [mm].
struct Refit {
  Eigen::Vector3d centre;
  double clearance;        // distance from the centre to the surface, negative if it is outside [mm]
  double stand_off;        // max |p - centre| - clearance over the patch [mm]
  std::uint64_t work = 0;  // number of triangles and patch points tested
};

/// Distance from `centre` to the farthest of `points`; 0 if there are none [mm].
double farthest(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& centre);

/// Minimises max over p in `patch` of |p - c|, minus the clearance d(c): a difference of two maxima, neither smooth nor
/// convex. Descends along the shortest vector of the epsilon-subdifferential, which is the difference of two convex
/// hulls (unit vectors from the farthest patch points, unit vectors from the nearest surface points found so far), with
/// a decreasing step. The result is never worse than the start. In a solid thinner than the stand-off the best centre
/// may lie slightly outside. Stops early when the stand-off is at most `target`.
/// Method: C. Lemarechal's epsilon-steepest descent, with E. Gilbert's algorithm (SIAM J. Control 4(1), 1966) for the
/// shortest vector. Cost: one distance query and one pass over the patch for each of at most `max_steps` steps.
Refit refitBall(const DistanceField& field, std::span<const Eigen::Vector3d> patch, const Eigen::Vector3d& start, double clearance,
                double first_step, int max_steps, double target = 0);

}  // namespace spheretree::builder
