// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_merge.h"

#include <algorithm>
#include <cmath>

#include "medial/refit_ball.h"
#include "published/initial_clusters.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

FittedBall bestOfThree(const Region& region, const MedialCluster& a, const MedialCluster& b, std::vector<Vector3d>& united) {
  const FittedBall first{a.ball.centre, std::max(a.ball.radius, farthest(b.points, a.ball.centre)), a.ball.clearance};
  const FittedBall second{b.ball.centre, std::max(b.ball.radius, farthest(a.points, b.ball.centre)), b.ball.clearance};
  FittedBall best = second.overhang() < first.overhang() ? second : first;
  united = a.points;
  united.insert(united.end(), b.points.begin(), b.points.end());
  const Ball smallest = smallestEnclosing(united);
  // The clearance is 1-Lipschitz in the centre: most third candidates need no distance query.
  const double max_clearance =
      std::min(a.ball.clearance + (smallest.centre - a.ball.centre).norm(), b.ball.clearance + (smallest.centre - b.ball.centre).norm());
  if (smallest.radius - max_clearance < best.overhang()) {
    const FittedBall third{smallest.centre, smallest.radius, -region.field.signedDistance(smallest.centre)};
    if (third.overhang() < best.overhang()) best = third;
  }
  return best;
}

}  // namespace

std::vector<FittedBall> reduceMerge(const Region& region) {
  if (region.pool.empty() || region.points.empty()) return {};
  return mergeClusters(region, startClusters(region), bestOfThree);
}

}  // namespace spheretree::builder
