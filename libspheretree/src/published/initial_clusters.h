// SPDX-License-Identifier: GPL-3.0-or-later
// Medial balls with the points of a region shared out among them: what Merge, Hubbard and Burst start from, and the
// greedy merging of neighbours that Merge and Hubbard share.
#pragma once

#include <cstdint>
#include <vector>

#include "published/region_reducer.h"

namespace spheretree::builder {

struct MedialCluster {
  FittedBall ball;                        // holds `points`
  std::vector<Eigen::Vector3d> points;    // [mm]
  std::vector<std::uint32_t> neighbours;  // indices of clusters, ascending
  bool alive = true;
};

/// Every point goes to the medial ball that it lies deepest in; balls without points are left out. Neighbours: balls
/// among the few nearest to a common point. Cost: O(balls * points).
std::vector<MedialCluster> startClusters(const Region& region);

/// The ball for the united points of two clusters; `united` is scratch memory.
using MergeRule = FittedBall (*)(const Region& region, const MedialCluster& a, const MedialCluster& b,
                                 std::vector<Eigen::Vector3d>& united);

/// Merges neighbours, below 24 clusters any two, until at most `region.max_balls` are left, and further while the merged
/// ball reaches out no farther than `region.target_overhang`. Merges that leave the worse of the two no worse go first, then the
/// least overhang; ties go to the lower clusters. No balls if the overhang would pass `region.limit`.
std::vector<FittedBall> mergeClusters(const Region& region, MergeRule rule);

}  // namespace spheretree::builder
