// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_expand.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <queue>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kExpandBisections = 10;

// gap = |p - c| - clearance: the stand-off at which a ball contains a point. The points of one ball are consecutive.
// Float suffices for the choice; radii are computed in double.
class Gaps {
 public:
  Gaps(std::span<const FittedBall> pool, std::span<const Vector3d> points) : points_(points.size()), gap_(pool.size() * points.size()) {
    float* out = gap_.data();
    for (const FittedBall& ball : pool)
      for (const Vector3d& p : points) *out++ = static_cast<float>((p - ball.centre).norm() - ball.clearance);
  }
  std::size_t balls() const { return gap_.size() / points_; }
  std::size_t points() const { return points_; }
  const float* of(std::size_t ball) const { return gap_.data() + ball * points_; }

 private:
  std::size_t points_;
  std::vector<float> gap_;
};

// Greedy set cover at one stand-off; empty if it would need more than `max_count` balls. Counts are upper bounds, and
// are recomputed only for the ball on top (they can only decrease).
std::vector<std::size_t> greedyCover(const Gaps& gaps, float stand_off, std::size_t max_count) {
  struct Gain {
    std::uint32_t gain;
    std::size_t ball;
    bool operator<(const Gain& o) const { return gain != o.gain ? gain < o.gain : ball > o.ball; }
  };
  const std::size_t m = gaps.points();
  std::vector<Gain> first(gaps.balls());
  for (std::size_t b = 0; b < first.size(); ++b) {
    const float* gap = gaps.of(b);
    std::uint32_t gain = 0;
    for (std::size_t i = 0; i < m; ++i) gain += gap[i] <= stand_off;
    first[b] = {gain, b};
  }
  std::priority_queue<Gain> queue(std::less<Gain>(), std::move(first));
  std::vector<std::uint8_t> open(m, 1);
  std::size_t left = m;
  std::vector<std::size_t> chosen;
  while (left > 0) {
    if (queue.empty() || chosen.size() == max_count) return {};
    const Gain top = queue.top();
    queue.pop();
    // Even the best remaining balls could not cover all remaining points.
    if (static_cast<std::size_t>(top.gain) * (max_count - chosen.size()) < left) return {};
    const float* gap = gaps.of(top.ball);
    std::uint32_t gain = 0;
    for (std::size_t i = 0; i < m; ++i) gain += static_cast<std::uint32_t>((gap[i] <= stand_off) & open[i]);
    if (gain < top.gain) {
      if (gain > 0) queue.push({gain, top.ball});
      continue;
    }
    for (std::size_t i = 0; i < m; ++i)
      if (gap[i] <= stand_off && open[i]) open[i] = 0, --left;
    chosen.push_back(top.ball);
  }
  return chosen;
}

}  // namespace

std::vector<FittedBall> reduceExpand(const Region& region) {
  if (region.pool.empty() || region.points.empty()) return {};
  const Gaps gaps(region.pool, region.points);
  // Below `low` some point is in no ball; at `high` one ball contains all points.
  std::vector<float> nearest(gaps.points(), std::numeric_limits<float>::infinity());
  float low = 0, high = std::numeric_limits<float>::infinity();
  std::size_t widest = 0;
  for (std::size_t b = 0; b < gaps.balls(); ++b) {
    const float* gap = gaps.of(b);
    float largest = 0;
    for (std::size_t i = 0; i < gaps.points(); ++i) {
      largest = std::max(largest, gap[i]);
      nearest[i] = std::min(nearest[i], gap[i]);
    }
    if (largest < high) high = largest, widest = b;
  }
  for (const float gap : nearest) low = std::max(low, gap);

  std::vector<std::size_t> cover{widest};
  float stand_off = high;
  const auto attempt = [&](float trial) {
    std::vector<std::size_t> found = greedyCover(gaps, trial, region.max_balls);
    if (found.empty()) return false;
    cover = std::move(found);
    stand_off = high = trial;
    return true;
  };
  const auto target = static_cast<float>(region.target_overhang);
  bool done = target >= high;
  if (!done && target > low) {
    done = attempt(target);
    if (!done) low = target;
  }
  for (int i = 0; i < kExpandBisections && !done && low < high; ++i) {
    const float middle = 0.5f * (low + high);
    if (!attempt(middle)) low = middle;
  }
  std::vector<FittedBall> balls;
  for (const std::size_t b : cover) {
    const FittedBall& medial = region.pool[b];
    balls.push_back({medial.centre, medial.clearance + static_cast<double>(stand_off), medial.clearance});
  }
  return balls;
}

}  // namespace spheretree::builder
