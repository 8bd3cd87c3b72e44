// SPDX-License-Identifier: GPL-3.0-or-later
// Regions of the surface as sets of points: what a node of a sphere-tree must cover, how its ball is fitted to it, and
// how overlapping balls divide it.
// Paper: G. Bradshaw, C. O'Sullivan, ACM Trans. Graphics 23(1), 2004. Departures:
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

struct SurfacePoints {
  std::vector<Eigen::Vector3d> points;
  std::vector<Ball> inner;           // (points) the largest ball inside the solid that touches there; radius 0 if unknown
  std::vector<double> ball_density;  // (points) how many spheres its neighbourhood takes, up to a factor; 0 for an added point
};

/// About `count` points spread evenly by area, points on sharp edges, and the corners of the triangles where they are
/// not many more. The ball_density of a point is its area over 2 r + h: r the radius of the largest inner ball that touches
/// there, h the stand-off that `spheres` balls would reach on average (docs/measures.md, h_fin). `wants_inner`: false
/// leaves out the inner balls of most points, for those who need the loads alone.
SurfacePoints sampleRegions(const TriangleMesh& mesh, const DistanceField& field, std::size_t count, std::size_t spheres,
                            std::uint64_t seed, bool wants_inner = true);

/// For each point the ball that it lies deepest in (the least |p - c| - clearance) among those that hold it; if none
/// does, the ball that must grow least, and it grows. `balls` must not be empty. Ties go to the lower index.
/// Cost: O((points + balls) log balls) for balls that overlap little.
std::vector<std::uint32_t> assignDeepest(std::span<const Eigen::Vector3d> points, std::vector<FittedBall>& balls);

/// Rounds of assignDeepest followed by a refit of each ball to its points (refit_ball.h); a centre outside the solid
/// moves in where that pays. The worst overhang never rises. Balls left without points get radius 0. Returns the owner
/// of each point. `rounds` >= 0: with 0 the balls only shrink to their points.
std::vector<std::uint32_t> refitBalls(const DistanceField& field, std::span<const Eigen::Vector3d> points, std::vector<FittedBall>& balls,
                                      int rounds, const Progress& progress);

/// Moves the centre of one ball to where it holds `patch` with the least overhang, and gives it the radius for that; a
/// centre outside the solid moves in where that pays. Stops early at an overhang of `target` [mm]. A patch without
/// points gives radius 0.
void refitToPatch(const DistanceField& field, std::span<const Eigen::Vector3d> patch, FittedBall& ball, double target = 0);

/// At most `most` of the points: each the farthest from those before, so that corners come first and the rest is spread
/// evenly. A reducer that does not see a corner misses it by far more than the spacing of its points. O(points * most).
std::vector<Eigen::Vector3d> farthestFirst(std::span<const Eigen::Vector3d> points, std::size_t most);

/// The balls that hold each point.
struct Holders {
  std::vector<std::size_t> begin;   // (points + 1) in `ball`
  std::vector<std::uint32_t> ball;  // of the first point, in ascending order, then of the second, and so on
  std::span<const std::uint32_t> of(std::size_t point) const { return {ball.data() + begin[point], begin[point + 1] - begin[point]}; }
};
Holders findHolders(std::span<const Eigen::Vector3d> points, std::span<const FittedBall> balls);

/// Marks balls so that the others still hold every point: goes through the balls by overhang, the largest first, and
/// marks each that holds no point alone by then. Balls in `gone` (empty: none) do not count, those in `fixed` (empty:
/// none) are kept. `group`: (balls) the last unmarked ball of a group is kept.
std::vector<char> maybeRedundant(const Holders& holders, std::span<const FittedBall> balls, std::span<const std::uint32_t> group,
                                 std::span<const char> fixed, std::span<const char> gone);

/// Divides the points among the balls that hold them, every pair of balls by a plane: the radical plane, shifted until
/// the densities of the points of each ball add up to sums as equal as the overlaps allow.
/// Returns the owner of each point; every point must lie in a ball, kNoParent stands for one that does not.
std::vector<std::uint32_t> assignToRegions(std::span<const Eigen::Vector3d> points, std::span<const double> ball_density,
                                           std::span<const FittedBall> balls);

}  // namespace spheretree::builder
