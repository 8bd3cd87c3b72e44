// SPDX-License-Identifier: GPL-3.0-or-later
// Regions of the surface as sets of points: how balls are fitted to the region that they cover, and how overlapping
// balls divide it.
// Paper: G. Bradshaw, C. O'Sullivan, ACM Trans. Graphics 23(1), 2004. Differences:
//         docs/algorithms/medial/surface_regions.md
// Units: mm, frame of the mesh. Deterministic for any number of threads.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Returns for each point the ball in which it lies deepest (smallest |p - c| - clearance) among the balls that contain
/// it. A point outside all balls gets the ball that needs the smallest growth, and that ball grows to contain it.
/// `balls` must not be empty. Ties go to the lower index. Cost: O((points + balls) log balls) for balls that overlap
/// little.
std::vector<std::uint32_t> assignDeepest(std::span<const Eigen::Vector3d> points, std::vector<FittedBall>& balls);

/// Repeats assignDeepest() and a refit of each ball to its points (refit_ball.h). A centre outside the solid is moved
/// inside if that lowers the overhang. The worst overhang never rises. Balls without points get radius 0. Returns the
/// owner of each point. `rounds` >= 0: with 0 the balls only shrink to their points.
std::vector<std::uint32_t> refitBalls(const DistanceField& field, std::span<const Eigen::Vector3d> points, std::vector<FittedBall>& balls,
                                      int rounds, const Progress& progress);

/// Moves the centre of one ball to where it covers `patch` with the smallest overhang, and sets its radius accordingly.
/// A centre outside the solid is moved inside if that lowers the overhang. Stops early at an overhang of `target` [mm].
/// A patch without points gives radius 0.
void refitToPatch(const DistanceField& field, std::span<const Eigen::Vector3d> patch, FittedBall& ball, double target = 0);

/// At most `max_count` of the points. Each is the farthest from those chosen before, so that corners come first and the
/// others are evenly spread. If a reducer does not see a corner, its balls miss the corner by far more than the spacing
/// of its points. Cost: O(points * max_count).
std::vector<Eigen::Vector3d> farthestFirst(std::span<const Eigen::Vector3d> points, std::size_t max_count);

/// The balls that contain each point.
struct Holders {
  std::vector<std::size_t> begin;   // (points + 1) index in `ball` where the balls of a point begin
  std::vector<std::uint32_t> ball;  // the balls of point 0 in ascending order, then those of point 1, and so on
  std::span<const std::uint32_t> of(std::size_t point) const { return {ball.data() + begin[point], begin[point + 1] - begin[point]}; }
};
Holders findHolders(std::span<const Eigen::Vector3d> points, std::span<const FittedBall> balls);

/// Marks balls such that the unmarked ones still contain every point: goes through the balls by overhang, the largest
/// first, and marks each ball that is not the only unmarked ball around some point. Balls in `absent` (may be empty) do
/// not count, balls in `fixed` (may be empty) stay unmarked. `group` (balls): the last unmarked ball of a group stays
/// unmarked.
std::vector<char> maybeRedundant(const Holders& holders, std::span<const FittedBall> balls, std::span<const std::uint32_t> group,
                                 std::span<const char> fixed, std::span<const char> absent);

/// Divides the points among the balls that contain them. For every pair of balls the boundary is a plane: the radical
/// plane, shifted until the balls have as equally many points as the overlaps allow. Returns the owner of each point.
/// Every point must lie in a ball; a point that does not gets kNone.
std::vector<std::uint32_t> assignToRegions(std::span<const Eigen::Vector3d> points, std::span<const FittedBall> balls);

}  // namespace spheretree::builder
