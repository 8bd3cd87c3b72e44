// SPDX-License-Identifier: GPL-3.0-or-later
// Medial balls among which the points of a region are divided: the start of Merge, Hubbard and Burst, and the greedy
// merging of neighbours that Merge and Hubbard share.
#pragma once

#include <cstdint>
#include <vector>

#include "published/region_reducer.h"

namespace spheretree::builder {

struct MedialCluster {
  FittedBall ball;                        // contains `points`
  std::vector<Eigen::Vector3d> points;    // [mm]
  std::vector<std::uint32_t> neighbours;  // indices of clusters, ascending
  bool alive = true;
};

/// Each point goes to the medial ball in which it lies deepest; balls without points are left out. Two balls are
/// neighbours if both are among the few balls nearest to a common point. Cost: O(balls * points).
std::vector<MedialCluster> startClusters(const Region& region);

/// The ball for the joint points of two clusters; `united` is scratch memory.
using MergeRule = FittedBall (*)(const Region& region, const MedialCluster& a, const MedialCluster& b,
                                 std::vector<Eigen::Vector3d>& united);

/// Merges neighbours among `clusters` (below 24 clusters any two) until at most `region.max_balls` clusters remain, and
/// further as long as the merged ball has an overhang of at most `region.target_overhang`. The merge with the smallest
/// overhang comes first; ties go to the lower clusters.
std::vector<FittedBall> mergeClusters(const Region& region, std::vector<MedialCluster> clusters, MergeRule rule);

}  // namespace spheretree::builder
