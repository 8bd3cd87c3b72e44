// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_hubbard.h"

#include "published/initial_clusters.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

FittedBall ballOfPoints(const Region& region, const MedialCluster& a, const MedialCluster& b, std::vector<Vector3d>& united) {
  united = a.points;
  united.insert(united.end(), b.points.begin(), b.points.end());
  const Ball smallest = smallestEnclosing(united);
  return {smallest.centre, smallest.radius, -region.field.signedDistance(smallest.centre)};
}

}  // namespace

std::vector<FittedBall> reduceHubbard(const Region& region) {
  if (region.pool.empty() || region.points.empty()) return {};
  return mergeClusters(region, startClusters(region), ballOfPoints);
}

}  // namespace spheretree::builder
