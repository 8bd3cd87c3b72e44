// SPDX-License-Identifier: GPL-3.0-or-later
// Evens out the balls of a level: splits the ball with the largest overhang, and removes the ball with the smallest
// loss to make room for it. Method and reasons: docs/algorithms/published/split_and_drop.md
// Units: mm, frame of the mesh. Deterministic for any number of threads.
#pragma once

#include <span>
#include <vector>

#include "geometry/distance_field.h"
#include "medial/surface_regions.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct SplitAndDropSettings {
  std::size_t max_balls = 512;  // >= 1
  double target_overhang = 0;   // the search stops when no ball has a larger overhang [mm]; >= 0
  int max_rounds = 24;          // >= 0
};

/// Changes `balls` until there are at most `max_balls` and no exchange lowers the worst overhang. If there are at most
/// `max_balls` at the start, the worst overhang never rises. On return each ball is the smallest one about its centre
/// that contains the points that lie deepest in it, and every point lies in a ball; balls without points are removed.
/// Cost: a round assigns all points, O(points log balls), and refits a few balls.
/// @throws std::invalid_argument for no points or no balls, Cancelled.
void splitAndDrop(const DistanceField& field, std::span<const Eigen::Vector3d> points, std::vector<FittedBall>& balls,
                  const SplitAndDropSettings& settings, const Progress& progress);

}  // namespace spheretree::builder
