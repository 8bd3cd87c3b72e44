// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_burst.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kHeirs = 8;  // balls that a point remembers; when all of them have burst, it looks for others

double sixthPower(double x) {
  const double cube = x * x * x;
  return cube * cube;
}

struct Heir {
  std::uint32_t ball;
  double distance, gap;  // of the point from the centre, and how far the ball would have to stand off to contain it [mm]
};

// What a burst does: the new owner of each point of the ball, the new radii of those that take points, and the cost.
struct Burst {
  std::vector<std::uint32_t> heir;  // (points of the ball) index in `takers`
  struct Taker {
    std::uint32_t ball;
    double radius;
  };
  std::vector<Taker> takers;
  double cost = std::numeric_limits<double>::infinity();
  double worst = 0;  // largest overhang of the balls that grow
};

class Burster {
 public:
  explicit Burster(const Region& region)
      : region_(region),
        balls_(region.pool.begin(), region.pool.end()),
        alive_(balls_.size(), 1),
        points_(balls_.size()),
        near_(region.points.size()),
        changed_(balls_.size(), 0),
        bursts_(balls_.size()) {
    for (FittedBall& ball : balls_) ball.radius = 0;
    for (std::uint32_t i = 0; i < near_.size(); ++i) {
      findHeirs(i);
      const Heir& first = near_[i].front();
      points_[first.ball].push_back(i);
      balls_[first.ball].radius = std::max(balls_[first.ball].radius, first.distance);
    }
    for (std::size_t b = 0; b < balls_.size(); ++b)
      if (points_[b].empty()) alive_[b] = 0;
    if (std::ranges::count(alive_, 1) < 2) return;  // nothing can burst
    for (std::uint32_t b = 0; b < balls_.size(); ++b)
      if (alive_[b]) bursts_[b] = plan(b);
  }

  std::vector<FittedBall> run() {
    auto left = static_cast<std::size_t>(std::ranges::count(alive_, 1));
    for (std::uint32_t step = 1; left > 1; ++step, --left) {
      std::size_t next = balls_.size();
      for (std::size_t b = 0; b < balls_.size(); ++b)
        if (alive_[b] && (next == balls_.size() || bursts_[b].cost < bursts_[next].cost)) next = b;
      if (left <= region_.max_balls && bursts_[next].worst > region_.target_overhang) break;
      apply(static_cast<std::uint32_t>(next), step);
    }
    std::vector<FittedBall> out;
    for (std::size_t b = 0; b < balls_.size(); ++b)
      if (alive_[b]) out.push_back(balls_[b]);
    return out;
  }

 private:
  // The balls alive that a point is nearest to.
  void findHeirs(std::uint32_t point) {
    std::vector<Heir>& near = near_[point];
    near.clear();
    for (std::uint32_t b = 0; b < balls_.size(); ++b) {
      if (!alive_[b]) continue;
      const double distance = (region_.points[point] - balls_[b].centre).norm();
      near.push_back({b, distance, distance - balls_[b].clearance});
    }
    const auto nearer = [](const Heir& x, const Heir& y) { return x.gap != y.gap ? x.gap < y.gap : x.ball < y.ball; };
    const std::size_t kept = std::min(kHeirs, near.size());
    std::ranges::nth_element(near, near.begin() + static_cast<std::ptrdiff_t>(kept), nearer);
    near.resize(kept);
    std::ranges::sort(near, nearer);
  }

  // Another ball that contains the point already, the nearest if there are several; otherwise the nearest.
  const Heir& heirOf(std::uint32_t point, std::uint32_t bursting, const Burst& burst) {
    while (true) {  // some other ball is alive
      const Heir* nearest = nullptr;
      for (const Heir& heir : near_[point]) {
        if (!alive_[heir.ball] || heir.ball == bursting) continue;
        if (!nearest) nearest = &heir;
        const auto taker = std::ranges::find(burst.takers, heir.ball, &Burst::Taker::ball);
        if (heir.distance <= (taker == burst.takers.end() ? balls_[heir.ball].radius : taker->radius)) return heir;
      }
      if (nearest) return *nearest;
      findHeirs(point);
    }
  }

  Burst plan(std::uint32_t bursting) {
    Burst burst;
    for (const std::uint32_t point : points_[bursting]) {
      const Heir& heir = heirOf(point, bursting, burst);
      auto taker = std::ranges::find(burst.takers, heir.ball, &Burst::Taker::ball);
      if (taker == burst.takers.end()) taker = burst.takers.insert(taker, {heir.ball, balls_[heir.ball].radius});
      taker->radius = std::max(taker->radius, heir.distance);
      burst.heir.push_back(static_cast<std::uint32_t>(taker - burst.takers.begin()));
    }
    burst.cost = 0;
    for (const Burst::Taker& taker : burst.takers) {
      const FittedBall& ball = balls_[taker.ball];
      if (!(taker.radius > ball.radius)) continue;
      const double after = std::max(0.0, taker.radius - ball.clearance), before = std::max(0.0, ball.overhang());
      burst.cost += sixthPower(after) - sixthPower(before);
      burst.worst = std::max(burst.worst, after);
    }
    return burst;
  }

  void apply(std::uint32_t bursting, std::uint32_t step) {
    const Burst burst = std::move(bursts_[bursting]);
    alive_[bursting] = 0;
    changed_[bursting] = step;
    for (std::size_t i = 0; i < burst.heir.size(); ++i) points_[burst.takers[burst.heir[i]].ball].push_back(points_[bursting][i]);
    for (const Burst::Taker& taker : burst.takers) {
      balls_[taker.ball].radius = taker.radius;
      changed_[taker.ball] = step;
    }
    if (std::ranges::count(alive_, 1) < 2) return;
    for (std::uint32_t b = 0; b < balls_.size(); ++b) {
      const auto isChanged = [&](const Burst::Taker& taker) { return changed_[taker.ball] == step; };
      if (alive_[b] && (changed_[b] == step || std::ranges::any_of(bursts_[b].takers, isChanged))) bursts_[b] = plan(b);
    }
  }

  const Region& region_;
  std::vector<FittedBall> balls_;
  std::vector<char> alive_;
  std::vector<std::vector<std::uint32_t>> points_;  // (balls) the points that the ball owns
  std::vector<std::vector<Heir>> near_;             // (points) the nearest balls, the nearest first
  std::vector<std::uint32_t> changed_;              // (balls) step of the last change
  std::vector<Burst> bursts_;                       // (balls)
};

}  // namespace

std::vector<FittedBall> reduceBurst(const Region& region) {
  if (region.pool.empty() || region.points.empty()) return {};
  return Burster(region).run();
}

}  // namespace spheretree::builder
