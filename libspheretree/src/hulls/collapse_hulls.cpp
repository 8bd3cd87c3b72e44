// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/collapse_hulls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <queue>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "hulls/hull_change.h"
#include "hulls/relax_balls.h"

namespace spheretree::builder {

namespace {

constexpr double kCostSteps = 20;  // collapses whose costs are in one such part of the limit are taken by their lengths
constexpr double kTried = 4;       // cost of a collapse that is tried, with the balls around it moved thereafter
constexpr int kFailures = 8;       // of such collapses one after the other, then no more are tried

using BallPair = std::pair<std::uint32_t, std::uint32_t>;  // from, to

std::vector<BallPair> pairsOf(const HullComplex& complex) {
  std::vector<BallPair> pairs;
  for (std::uint32_t v = 0; v < complex.balls().size(); ++v)
    for (const std::uint32_t w : complex.neighbours(v)) pairs.push_back({v, w});
  return pairs;
}

// Of the collapse of each pair.
std::vector<double> costsOf(const HullComplex& complex, std::span<const BallPair> pairs, double limit) {
  std::vector<double> costs(pairs.size());
  tbb::parallel_for(std::size_t{0}, pairs.size(),
                    [&](std::size_t i) { costs[i] = collapseOf(complex, pairs[i].first, pairs[i].second, limit).cost; });
  return costs;
}

class CollapseQueue {
 public:
  explicit CollapseQueue(HullComplex& complex) : complex_(complex) { push(pairsOf(complex)); }

  void run() {
    while (!queue_.empty()) {
      complex_.task().progress.check();
      const Entry e = queue_.top();
      const auto [from, to] = e.pair;
      queue_.pop();
      if (complex_.around(from).empty() || complex_.around(to).empty()) continue;
      const HullChange c = collapseOf(complex_, from, to, complex_.most());
      if (c.cost > complex_.most()) continue;
      if (stepOf(c.cost) > e.step) {
        queue_.push({stepOf(c.cost), e.length, e.pair});
        continue;
      }
      complex_.apply(c);
      std::vector<BallPair> pairs;
      for (const std::uint32_t w : complex_.neighbours(to)) pairs.push_back({to, w}), pairs.push_back({w, to});
      push(pairs);
    }
  }

 private:
  struct Entry {
    double step, length;
    BallPair pair;
    bool operator>(const Entry& other) const { return std::tie(step, length, pair) > std::tie(other.step, other.length, other.pair); }
  };

  double stepOf(double cost) const { return std::floor(kCostSteps * cost / complex_.most()); }

  void push(std::span<const BallPair> pairs) {
    const std::vector<double> costs = costsOf(complex_, pairs, complex_.most());
    const std::vector<Ball>& balls = complex_.balls();
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (costs[i] <= complex_.most())
        queue_.push({stepOf(costs[i]), (balls[pairs[i].first].centre - balls[pairs[i].second].centre).norm(), pairs[i]});
  }

  HullComplex& complex_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_{};
};

class CollapseTrials {
 public:
  explicit CollapseTrials(HullComplex& complex) : complex_(complex), limit_(kTried * complex.most()) {}

  void run() {
    while (failures_ < kFailures && hasCollapsed()) {
    }
  }

 private:
  // Tries all pairs that have not failed, the least costly first, until one succeeds.
  bool hasCollapsed() {
    complex_.compact();
    std::vector<BallPair> pairs = pairsOf(complex_);
    std::erase_if(pairs, [&](const BallPair& p) { return failed_.contains(p); });
    const std::vector<double> costs = costsOf(complex_, pairs, limit_);
    std::vector<std::pair<double, BallPair>> order;
    for (std::size_t i = 0; i < pairs.size(); ++i)
      if (costs[i] <= limit_) order.push_back({costs[i], pairs[i]});
    std::ranges::sort(order);
    for (const auto& [cost, pair] : order) {
      if (failures_ == kFailures) return false;
      complex_.task().progress.check();
      if (collapses(pair)) {
        failures_ = 0;
        return true;
      }
      ++failures_;
      failed_.insert(pair);
    }
    return false;
  }

  // Undone if it leaves places bare.
  bool collapses(const BallPair& pair) {
    HullComplex before = complex_;
    const std::size_t missed = misses();
    complex_.apply(collapseOf(complex_, pair.first, pair.second, limit_));
    relaxBalls(complex_, pair.second, limit_);
    if (misses() <= missed && (isCovered() || missed > 0)) return true;
    complex_.restore(std::move(before));
    return false;
  }

  // Whether the hulls now hold all pieces, perhaps after balls have been moved.
  bool isCovered() {
    for (int round = 0; round < kBareRounds; ++round) {
      if (!complex_.addBare()) return true;
      if (misses() > 0) mend();
      if (misses() > 0) return false;
    }
    return false;
  }

  // Moves balls where samples are not held. If that does not help, they are where they were.
  void mend() {
    std::vector<std::uint32_t> nearest;
    for (const FitSample& s : complex_.samples())
      if (s.cost > complex_.most())
        if (const std::uint32_t v = nearestTo(s.point); std::ranges::find(nearest, v) == nearest.end()) nearest.push_back(v);
    for (const std::uint32_t v : nearest) {
      if (complex_.around(v).empty()) continue;
      const std::size_t missed = misses();
      HullComplex before = complex_;
      relaxBalls(complex_, v, limit_);
      if (misses() > missed) complex_ = std::move(before);
    }
  }

  std::uint32_t nearestTo(const Eigen::Vector3d& p) const {
    std::uint32_t nearest = 0;
    double least = kInfinity;
    for (std::uint32_t v = 0; v < complex_.balls().size(); ++v) {
      const Ball& ball = complex_.balls()[v];
      if (const double far = (p - ball.centre).norm() - ball.radius; far < least && !complex_.around(v).empty()) least = far, nearest = v;
    }
    return nearest;
  }

  // Samples and hulls that cost more than they may.
  std::size_t misses() const {
    std::size_t count = 0;
    for (const FitSample& s : complex_.samples()) count += s.cost > complex_.most();
    for (const Simplex& s : complex_.simplices()) count += s.is_alive && s.overhang > complex_.most();
    return count;
  }

  HullComplex& complex_;
  double limit_;  // that hulls and samples may cost until balls are moved [mm]
  int failures_ = 0;
  std::set<BallPair> failed_{};
};

}  // namespace

void collapseBalls(HullComplex& complex) { CollapseQueue(complex).run(); }

void tryCollapses(HullComplex& complex) { CollapseTrials(complex).run(); }

}  // namespace spheretree::builder
