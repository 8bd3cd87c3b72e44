// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/reduce_merge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <queue>

#include "spheretree/builder/smallest_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kAllPairsBelow = 24;
constexpr std::size_t kNear = 5;  // the balls nearest to a point are neighbours of its owner

struct Cluster {
  FittedBall ball;
  std::vector<Vector3d> points;
  std::vector<std::uint32_t> neighbours;  // sorted
  bool alive = true;
};

struct Merge {
  bool worsens = true;  // the merged ball reaches out farther than the worse of the two
  double overhang = 0;
  std::uint32_t a = 0, b = 0;
  FittedBall ball;
  bool operator<(const Merge& o) const {  // true: later
    if (worsens != o.worsens) return worsens;
    if (overhang != o.overhang) return overhang > o.overhang;
    return a != o.a ? a > o.a : b > o.b;
  }
};

double farthest(const Vector3d& c, const std::vector<Vector3d>& points) {
  double most = 0;
  for (const Vector3d& p : points) most = std::max(most, (p - c).squaredNorm());
  return std::sqrt(most);
}

void insertSorted(std::vector<std::uint32_t>& list, std::uint32_t value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at == list.end() || *at != value) list.insert(at, value);
}

void eraseSorted(std::vector<std::uint32_t>& list, std::uint32_t value) {
  const auto at = std::lower_bound(list.begin(), list.end(), value);
  if (at != list.end() && *at == value) list.erase(at);
}

std::vector<Cluster> startClusters(const Region& region) {
  std::vector<Cluster> of_ball(region.pool.size());
  std::vector<std::array<std::uint32_t, kNear>> near(region.points.size());
  const std::size_t nearest = std::min(kNear, region.pool.size());
  for (std::size_t i = 0; i < region.points.size(); ++i) {
    std::array<double, kNear> gaps;
    gaps.fill(std::numeric_limits<double>::infinity());
    for (std::uint32_t b = 0; b < region.pool.size(); ++b) {
      double gap = (region.points[i] - region.pool[b].centre).norm() - region.pool[b].clearance;
      if (gap >= gaps[nearest - 1]) continue;
      std::size_t k = nearest - 1;
      for (; k > 0 && gaps[k - 1] > gap; --k) gaps[k] = gaps[k - 1], near[i][k] = near[i][k - 1];
      gaps[k] = gap, near[i][k] = b;
    }
    of_ball[near[i][0]].points.push_back(region.points[i]);
  }
  std::vector<std::uint32_t> number(region.pool.size(), kNoParent);
  std::vector<Cluster> clusters;
  for (std::size_t b = 0; b < of_ball.size(); ++b) {
    if (of_ball[b].points.empty()) continue;
    number[b] = static_cast<std::uint32_t>(clusters.size());
    const MedialBall& medial = region.pool[b];
    of_ball[b].ball = {medial.centre, medial.clearance, farthest(medial.centre, of_ball[b].points)};
    clusters.push_back(std::move(of_ball[b]));
  }
  for (const auto& list : near)
    for (std::size_t k = 1; k < nearest; ++k) {
      const std::uint32_t a = number[list[0]], b = number[list[k]];
      if (b == kNoParent || a == b) continue;
      insertSorted(clusters[a].neighbours, b);
      insertSorted(clusters[b].neighbours, a);
    }
  return clusters;
}

Merge evaluate(const Region& region, const Cluster& x, const Cluster& y, std::uint32_t a, std::uint32_t b, std::vector<Vector3d>& united) {
  Merge merge;
  merge.a = a, merge.b = b;
  merge.ball = {x.ball.centre, x.ball.clearance, std::max(x.ball.radius, farthest(x.ball.centre, y.points))};
  const FittedBall other{y.ball.centre, y.ball.clearance, std::max(y.ball.radius, farthest(y.ball.centre, x.points))};
  if (other.overhang() < merge.ball.overhang()) merge.ball = other;
  united = x.points;
  united.insert(united.end(), y.points.begin(), y.points.end());
  const Ball smallest = smallestBall(united);
  // The clearance changes no faster than the centre moves: most third candidates need no distance query.
  const double most_clearance = std::min(x.ball.clearance + (smallest.centre - x.ball.centre).norm(),
                                         y.ball.clearance + (smallest.centre - y.ball.centre).norm());
  if (smallest.radius - most_clearance < merge.ball.overhang()) {
    const FittedBall third{smallest.centre, -region.field.signedDistance(smallest.centre), smallest.radius};
    if (third.overhang() < merge.ball.overhang()) merge.ball = third;
  }
  merge.overhang = merge.ball.overhang();
  merge.worsens = merge.overhang > std::max(x.ball.overhang(), y.ball.overhang());
  return merge;
}

}  // namespace

std::vector<FittedBall> reduceMerge(const Region& region) {
  if (region.pool.empty() || region.points.empty()) return {};
  std::vector<Cluster> clusters = startClusters(region);
  std::priority_queue<Merge> queue;
  std::vector<Vector3d> united;
  const auto consider = [&](std::uint32_t a, std::uint32_t b) { queue.push(evaluate(region, clusters[a], clusters[b], a, b, united)); };
  for (std::uint32_t a = 0; a < clusters.size(); ++a)
    for (const std::uint32_t b : clusters[a].neighbours)
      if (a < b) consider(a, b);

  std::size_t alive = clusters.size();
  bool all_pairs = false;
  while (alive > 1) {
    if (all_pairs && queue.empty()) break;
    if (!all_pairs && (alive < kAllPairsBelow || queue.empty())) {  // empty: parts that no chain of neighbours joins
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
    if (alive <= region.most && merge.overhang > region.enough) {
      if (merge.worsens) break;
      continue;
    }
    if (alive > region.most && merge.overhang > region.limit) return {};
    const auto made = static_cast<std::uint32_t>(clusters.size());
    clusters.emplace_back();
    Cluster &x = clusters[merge.a], &y = clusters[merge.b], &z = clusters[made];
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
      clusters[n].neighbours.push_back(made);  // the highest number
      consider(n, made);
    }
    --alive;
  }
  std::vector<FittedBall> balls;
  for (const Cluster& c : clusters)
    if (c.alive) balls.push_back(c.ball);
  return balls;
}

}  // namespace spheretree::builder
