// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_spawn.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/thinned.h"
#include "medial/shrinking_balls.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kStarts = 4;
constexpr int kHalvings = 4;
constexpr int kSpawnBisections = 8;

struct Placed {
  Ball inner;  // radius: the clearance
  std::size_t gain = 0;
};

class Spawner {
 public:
  explicit Spawner(const Region& region) : region_(region) {}

  // Balls of one stand-off; empty if more than `max_balls` would be needed.
  std::vector<FittedBall> attempt(double stand_off) const {
    std::vector<Vector3d> open(region_.points.begin(), region_.points.end());
    std::vector<FittedBall> balls;
    while (!open.empty()) {
      if (balls.size() == region_.max_balls) return {};
      const Placed best = place(open, stand_off);
      if (best.gain == 0 || best.gain * (region_.max_balls - balls.size()) < open.size()) return {};
      const double reach = best.inner.radius + stand_off;
      balls.push_back({best.inner.centre, reach, best.inner.radius});
      std::erase_if(open, [&](const Vector3d& p) { return (p - best.inner.centre).squaredNorm() <= reach * reach; });
    }
    return balls;
  }

 private:
  static std::size_t gain(const std::vector<Vector3d>& open, const Vector3d& centre, double reach) {
    std::size_t count = 0;
    for (const Vector3d& p : open) count += (p - centre).squaredNorm() <= reach * reach;
    return count;
  }

  // A pattern search from the inner balls of a few uncovered points.
  Placed place(const std::vector<Vector3d>& open, double stand_off) const {
    Placed best;
    for (const Vector3d& p : thinned(open, kStarts)) {
      Ball now = touchingBall(region_.field, p);
      if (!(now.radius > 0)) continue;
      std::size_t count = gain(open, now.centre, now.radius + stand_off);
      double step = 0.5 * std::sqrt(stand_off * (2 * now.radius + stand_off));
      for (int halving = 0; halving < kHalvings;) {
        bool moved = false;
        for (int k = 0; k < 6; ++k) {
          const Vector3d trial = now.centre + (k % 2 == 0 ? step : -step) * Vector3d::Unit(k / 2);
          const double clearance = -region_.field.signedDistance(trial);
          if (!(clearance > 0)) continue;
          const std::size_t held = gain(open, trial, clearance + stand_off);
          if (held > count) now = {trial, clearance}, count = held, moved = true;
        }
        if (!moved) step *= 0.5, ++halving;
      }
      if (count > best.gain) best = {now, count};
    }
    return best;
  }

  const Region& region_;
};

}  // namespace

std::vector<FittedBall> reduceSpawn(const Region& region) {
  if (region.points.empty()) return {};
  const Spawner spawner(region);
  const Ball smallest = smallestEnclosing(region.points);
  const FittedBall one{smallest.centre, smallest.radius, -region.field.signedDistance(smallest.centre)};
  std::vector<FittedBall> best{one};
  double low = 0, high = one.overhang();
  const auto attempt = [&](double trial) {
    std::vector<FittedBall> balls = spawner.attempt(trial);
    if (balls.empty()) return false;
    best = std::move(balls);
    high = trial;
    return true;
  };
  bool done = region.target_overhang >= high;
  if (!done && region.target_overhang > 0) {
    done = attempt(region.target_overhang);
    if (!done) low = region.target_overhang;
  }
  for (int i = 0; i < kSpawnBisections && !done; ++i) {
    const double middle = 0.5 * (low + high);
    if (!attempt(middle)) low = middle;
  }
  return best;
}

}  // namespace spheretree::builder
