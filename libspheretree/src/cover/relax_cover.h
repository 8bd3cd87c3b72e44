// SPDX-License-Identifier: GPL-3.0-or-later
// Moves the balls of a finished cover to where they cover a finer surface than the one that they were searched on.
// Method: S. Lloyd. Least squares quantization in PCM. IEEE Trans. Information Theory 28(2), 1982; with the largest gap
//         instead of the mean square.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Gives each of the `points` (of the surface of `field`) to the ball that reaches it with the smallest stand-off, and
/// refits each ball to its points, as long as that lowers the stand-off of all by a hundredth. The radii become the
/// clearances in `field` plus that stand-off, so that every point is covered. `moved`: distance of the surface from the
/// one that the balls covered [mm]; nothing changes if it is below a hundredth of the stand-off. The same balls for any
/// number of threads. Cost: a search in a tree of balls for each point, and some 30 distances for each point and round.
/// @throws Cancelled.
void relaxCover(const DistanceField& field, std::span<const Eigen::Vector3d> points, double moved, std::vector<Ball>& balls,
                Progress& progress);

}  // namespace spheretree::builder
