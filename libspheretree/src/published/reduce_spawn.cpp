// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_spawn.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "medial/shrinking_balls.h"
#include "spheretree/core/smallest_enclosing_ball.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kMaxPoints = 400;
constexpr std::size_t kStarts = 4;
constexpr int kHalvings = 4;
constexpr int kSpawnBisections = 8;

struct Placed {
  Ball inner;  // radius: the clearance
  std::size_t gain = 0;
};

class Spawner {
 public:
  explicit Spawner(const Region& region) : region_(region), points_(region.points.first(std::min(kMaxPoints, region.points.size()))) {
    for (const Vector3d& p : points_) start_.push_back(touchingBall(region.field, p));
  }
  std::span<const Vector3d> points() const { return points_; }
  const std::vector<Ball>& starts() const { return start_; }

  // Balls of one stand-off; empty if more than `max_balls` would be needed.
  std::vector<FittedBall> attempt(double stand_off) const {
    std::vector<Vector3d> open(points_.begin(), points_.end());
    std::vector<std::size_t> index(open.size());
    for (std::size_t i = 0; i < index.size(); ++i) index[i] = i;
    std::vector<FittedBall> balls;
    while (!open.empty()) {
      if (balls.size() == region_.max_balls) return {};
      const Placed best = place(open, index, stand_off);
      if (best.gain == 0 || best.gain * (region_.max_balls - balls.size()) < open.size()) return {};
      const double reach = best.inner.radius + stand_off;
      balls.push_back({best.inner.centre, reach, best.inner.radius});
      std::size_t kept = 0;
      for (std::size_t i = 0; i < open.size(); ++i)
        if ((open[i] - best.inner.centre).norm() > reach) open[kept] = open[i], index[kept] = index[i], ++kept;
      open.resize(kept);
      index.resize(kept);
    }
    return balls;
  }

 private:
  static std::size_t gain(const std::vector<Vector3d>& open, const Vector3d& centre, double reach) {
    std::size_t count = 0;
    for (const Vector3d& p : open) count += (p - centre).squaredNorm() <= reach * reach;
    return count;
  }

  // A pattern search from the inner balls of some uncovered points; the points are in a well-spread order, so the first
  // ones are used.
  Placed place(const std::vector<Vector3d>& open, const std::vector<std::size_t>& index, double stand_off) const {
    Placed best;
    std::size_t tried = 0;
    for (std::size_t i = 0; i < open.size() && tried < kStarts; ++i) {
      Ball now = start_[index[i]];
      if (!(now.radius > 0)) continue;
      ++tried;
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
  std::span<const Vector3d> points_;
  std::vector<Ball> start_;
};

}  // namespace

std::vector<FittedBall> reduceSpawn(const Region& region) {
  if (region.points.empty()) return {};
  const Spawner spawner(region);
  // One ball: about the centre of the smallest ball, or about the start that contains all points with the smallest
  // stand-off.
  const Ball smallest = smallestEnclosing(spawner.points());
  FittedBall one{smallest.centre, smallest.radius, -region.field.signedDistance(smallest.centre)};
  for (const Ball& start : spawner.starts()) {
    if (!(start.radius > 0)) continue;
    double reach = 0;
    for (const Vector3d& p : spawner.points()) reach = std::max(reach, (p - start.centre).norm());
    if (reach - start.radius < one.overhang()) one = {start.centre, reach, start.radius};
  }
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
