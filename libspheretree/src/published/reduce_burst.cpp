// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_burst.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "published/initial_clusters.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

double sixthPower(double x) {
  const double cube = x * x * x;
  return cube * cube;
}

// The plan of a removal: the new owner of each point, the new radii of the neighbours, and the cost.
struct Burst {
  std::vector<std::uint32_t> heir;  // (points) index in the neighbours
  std::vector<double> radius;       // (neighbours)
  double cost = std::numeric_limits<double>::infinity();
  double worst = 0;  // largest overhang of the neighbours that grow
};

Burst plan(const std::vector<MedialCluster>& clusters, const MedialCluster& bursting) {
  Burst burst;
  const auto& near = bursting.neighbours;
  if (near.empty()) return burst;
  for (const std::uint32_t n : near) burst.radius.push_back(clusters[n].ball.radius);
  burst.heir.reserve(bursting.points.size());
  for (const Vector3d& p : bursting.points) {
    // A neighbour that already contains the point comes first, otherwise the one with the smallest overhang afterwards.
    bool held = false;
    double smallest = std::numeric_limits<double>::infinity(), reach = 0;
    std::uint32_t heir = 0;
    for (std::uint32_t k = 0; k < near.size(); ++k) {
      const FittedBall& ball = clusters[near[k]].ball;
      const double distance = (p - ball.centre).norm(), gap = distance - ball.clearance;
      const bool holds = distance <= burst.radius[k];
      if (holds == held ? gap < smallest : holds) held = holds, smallest = gap, heir = k, reach = distance;
    }
    burst.heir.push_back(heir);
    burst.radius[heir] = std::max(burst.radius[heir], reach);
  }
  burst.cost = 0;
  for (std::size_t k = 0; k < near.size(); ++k) {
    const FittedBall& ball = clusters[near[k]].ball;
    if (!(burst.radius[k] > ball.radius)) continue;
    const double after = std::max(0.0, burst.radius[k] - ball.clearance), before = std::max(0.0, ball.overhang());
    burst.cost += sixthPower(after) - sixthPower(before);
    burst.worst = std::max(burst.worst, after);
  }
  return burst;
}

}  // namespace

std::vector<FittedBall> reduceBurst(const Region& region) {
  if (region.pool.empty() || region.points.empty()) return {};
  std::vector<MedialCluster> clusters = startClusters(region);
  std::vector<Burst> bursts(clusters.size());
  for (std::size_t c = 0; c < clusters.size(); ++c) bursts[c] = plan(clusters, clusters[c]);
  std::vector<char> needs_plan(clusters.size(), 0);
  std::size_t alive = clusters.size();
  while (alive > 1) {
    std::size_t next = clusters.size();
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      if (!clusters[c].alive) continue;
      if (needs_plan[c]) bursts[c] = plan(clusters, clusters[c]), needs_plan[c] = 0;
      if (next == clusters.size() || bursts[c].cost < bursts[next].cost) next = c;
    }
    if (!std::isfinite(bursts[next].cost)) {  // parts without connecting neighbours: from now on all balls are neighbours
      std::vector<std::uint32_t> left;
      for (std::uint32_t c = 0; c < clusters.size(); ++c)
        if (clusters[c].alive) left.push_back(c);
      for (const std::uint32_t c : left) {
        clusters[c].neighbours.clear();
        std::copy_if(left.begin(), left.end(), std::back_inserter(clusters[c].neighbours), [c](std::uint32_t n) { return n != c; });
        needs_plan[c] = 1;
      }
      continue;
    }
    if (alive <= region.max_balls && bursts[next].worst > region.target_overhang) break;
    const Burst burst = std::move(bursts[next]);
    MedialCluster& removed = clusters[next];
    removed.alive = false;
    --alive;
    for (std::size_t i = 0; i < removed.points.size(); ++i) clusters[removed.neighbours[burst.heir[i]]].points.push_back(removed.points[i]);
    for (std::size_t k = 0; k < removed.neighbours.size(); ++k) {
      MedialCluster& heir = clusters[removed.neighbours[k]];
      heir.ball.radius = burst.radius[k];
      // The neighbours of the removed ball become neighbours of each other.
      std::vector<std::uint32_t> joined;
      std::set_union(heir.neighbours.begin(), heir.neighbours.end(), removed.neighbours.begin(), removed.neighbours.end(),
                     std::back_inserter(joined));
      std::erase(joined, removed.neighbours[k]);
      std::erase(joined, static_cast<std::uint32_t>(next));
      heir.neighbours = std::move(joined);
    }
    for (const std::uint32_t n : removed.neighbours) {
      needs_plan[n] = 1;
      for (const std::uint32_t far : clusters[n].neighbours) needs_plan[far] = 1;
    }
  }
  std::vector<FittedBall> balls;
  for (const MedialCluster& c : clusters)
    if (c.alive) balls.push_back(c.ball);
  return balls;
}

}  // namespace spheretree::builder
