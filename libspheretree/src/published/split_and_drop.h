// SPDX-License-Identifier: GPL-3.0-or-later
// Evens out the balls of a level: the one that reaches out farthest is split, the one that is missed least makes room
// for it. What it does and why: docs/algorithms/published/split_and_drop.md
// Units: mm, frame of the mesh. Deterministic for any number of threads.
#pragma once

#include <span>
#include <vector>

#include "geometry/distance_field.h"
#include "medial/surface_regions.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct SplitAndDropSettings {
  std::size_t most = 512;  // balls, >= 1
  double enough = 0;       // stops once no ball reaches out farther [mm]; >= 0
  int rounds = 24;         // >= 0
};

/// Changes `balls` until they are at most `most` and no exchange lowers the worst overhang. If they are at most `most`
/// at the start, the worst overhang never rises. On return every point lies in a ball and each ball is no larger than
/// the points take that lie deepest in it; a ball without a point is gone. Cost: a round assigns all points, O(points
/// log balls), and refits a few balls.
/// @throws std::invalid_argument for no points or no balls, Cancelled.
void splitAndDrop(const DistanceField& field, std::span<const Eigen::Vector3d> points, std::vector<FittedBall>& balls,
                  const SplitAndDropSettings& settings, const Progress& progress);

}  // namespace spheretree::builder
