// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/initial_clusters.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <queue>

#include "medial/refit_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kAllPairsBelow = 24;
constexpr std::size_t kNear = 5;  // the balls nearest to a point are neighbours of its owner

struct Merge {
  double overhang = 0;
  std::uint32_t a = 0, b = 0;
  FittedBall ball;
  bool operator<(const Merge& o) const {  // true: is merged later
    if (overhang != o.overhang) return overhang > o.overhang;
    return a != o.a ? a > o.a : b > o.b;
  }
};

void insertSorted(std::vector<std::uint32_t>& list, std::uint32_t value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at == list.end() || *at != value) list.insert(at, value);
}

void eraseSorted(std::vector<std::uint32_t>& list, std::uint32_t value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at != list.end() && *at == value) list.erase(at);
}

Merge evaluate(const Region& region, MergeRule rule, const std::vector<MedialCluster>& clusters, std::uint32_t a, std::uint32_t b,
               std::vector<Vector3d>& united) {
  Merge merge;
  merge.a = a, merge.b = b;
  merge.ball = rule(region, clusters[a], clusters[b], united);
  merge.overhang = merge.ball.overhang();
  return merge;
}

}  // namespace

std::vector<MedialCluster> startClusters(const Region& region) {
  std::vector<MedialCluster> of_ball(region.pool.size());
  std::vector<std::array<std::uint32_t, kNear>> near(region.points.size());
  const std::size_t nearest = std::min(kNear, region.pool.size());
  for (std::size_t i = 0; i < region.points.size(); ++i) {
    std::array<double, kNear> gaps;
    gaps.fill(std::numeric_limits<double>::infinity());
    for (std::uint32_t b = 0; b < region.pool.size(); ++b) {
      const double reach = gaps[nearest - 1] + region.pool[b].clearance, square = (region.points[i] - region.pool[b].centre).squaredNorm();
      if (!(reach > 0) || square >= reach * reach) continue;
      const double gap = std::sqrt(square) - region.pool[b].clearance;
      std::size_t k = nearest - 1;
      for (; k > 0 && gaps[k - 1] > gap; --k) gaps[k] = gaps[k - 1], near[i][k] = near[i][k - 1];
      gaps[k] = gap, near[i][k] = b;
    }
    of_ball[near[i][0]].points.push_back(region.points[i]);
  }
  std::vector<std::uint32_t> number(region.pool.size(), kNone);
  std::vector<MedialCluster> clusters;
  for (std::size_t b = 0; b < of_ball.size(); ++b) {
    if (of_ball[b].points.empty()) continue;
    number[b] = static_cast<std::uint32_t>(clusters.size());
    const FittedBall& medial = region.pool[b];
    of_ball[b].ball = {medial.centre, farthest(of_ball[b].points, medial.centre), medial.clearance};
    clusters.push_back(std::move(of_ball[b]));
  }
  for (const auto& list : near)
    for (std::size_t k = 1; k < nearest; ++k) {
      const std::uint32_t a = number[list[0]], b = number[list[k]];
      if (b == kNone || a == b) continue;
      insertSorted(clusters[a].neighbours, b);
      insertSorted(clusters[b].neighbours, a);
    }
  return clusters;
}

std::vector<FittedBall> mergeClusters(const Region& region, std::vector<MedialCluster> clusters, MergeRule rule) {
  std::priority_queue<Merge> queue;
  std::vector<Vector3d> united;
  const auto consider = [&](std::uint32_t a, std::uint32_t b) { queue.push(evaluate(region, rule, clusters, a, b, united)); };
  for (std::uint32_t a = 0; a < clusters.size(); ++a)
    for (const std::uint32_t b : clusters[a].neighbours)
      if (a < b) consider(a, b);

  std::size_t alive = clusters.size();
  bool all_pairs = false;
  while (alive > 1) {
    if (all_pairs && queue.empty()) break;
    if (!all_pairs && (alive < kAllPairsBelow || queue.empty())) {  // empty: there are parts without connecting neighbours
      all_pairs = alive < kAllPairsBelow;
      std::vector<std::uint32_t> left;
      for (std::uint32_t c = 0; c < clusters.size(); ++c)
        if (clusters[c].alive) left.push_back(c);
      for (std::size_t i = 0; i < left.size(); ++i)
        for (std::size_t j = i + 1; j < left.size(); ++j) {
          const auto& known = clusters[left[i]].neighbours;
          if (std::binary_search(known.begin(), known.end(), left[j])) continue;
          insertSorted(clusters[left[i]].neighbours, left[j]);
          insertSorted(clusters[left[j]].neighbours, left[i]);
          consider(left[i], left[j]);
        }
    }
    const Merge merge = queue.top();
    queue.pop();
    if (!clusters[merge.a].alive || !clusters[merge.b].alive) continue;
    if (alive <= region.max_balls && merge.overhang > region.target_overhang) break;
    const auto made = static_cast<std::uint32_t>(clusters.size());
    clusters.emplace_back();
    MedialCluster &x = clusters[merge.a], &y = clusters[merge.b], &z = clusters[made];
    x.alive = y.alive = false;
    z.ball = merge.ball;
    z.points = std::move(x.points);
    z.points.insert(z.points.end(), y.points.begin(), y.points.end());
    y.points.clear();
    std::set_union(x.neighbours.begin(), x.neighbours.end(), y.neighbours.begin(), y.neighbours.end(), std::back_inserter(z.neighbours));
    eraseSorted(z.neighbours, merge.a);
    eraseSorted(z.neighbours, merge.b);
    for (const std::uint32_t n : z.neighbours) {
      eraseSorted(clusters[n].neighbours, merge.a);
      eraseSorted(clusters[n].neighbours, merge.b);
      clusters[n].neighbours.push_back(made);  // the new cluster has the highest number
      consider(n, made);
    }
    --alive;
  }
  std::vector<FittedBall> balls;
  for (const MedialCluster& c : clusters)
    if (c.alive) balls.push_back(c.ball);
  return balls;
}

}  // namespace spheretree::builder
