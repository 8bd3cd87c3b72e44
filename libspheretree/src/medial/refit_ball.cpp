// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/refit_ball.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kMaxNear = 12;  // number of stored surface points
constexpr std::size_t kMaxFar = 48;   // patch points of the epsilon-subdifferential
constexpr int kGilbertSteps = 24;
constexpr double kGilbertGap = 0.02;    // error of the square of the shortest vector, as a share, at which Gilbert's method ends
constexpr double kFlat = 0.05;          // subgradients shorter than this count as zero
constexpr double kSmallestStep = 1e-3;  // the descent ends below this share of its first step
constexpr double kActive = 0.5;         // points are active within this share of the step
constexpr double kFlatStep = 0.35;      // factors on the step if there is no slope, ...
constexpr double kFailedStep = 0.5;     // ... after a failure, ...
constexpr double kGoodStep = 1.3;       // ... and after a success

// The first of the points with the smallest projection on a direction.
std::size_t minAlong(const Vector3d& direction, std::span<const Vector3d> all) {
  std::size_t at = 0;
  double lowest = all[0].dot(direction);
  for (std::size_t i = 1; i < all.size(); ++i) {
    const double along = all[i].dot(direction);
    if (along < lowest) lowest = along, at = i;
  }
  return at;
}

// The shortest vector of conv(pull) - conv(push), to within 2 %; if it is shorter than kFlat, any vector shorter than
// that. Gilbert's method, which here moves towards the last corner of the difference as well as towards the current
// one: otherwise the steps alternate between two corners.
// Paper: E. Gilbert. An iterative procedure for computing the minimum of a quadratic form on a convex set. SIAM J.
//         Control 4(1), 1966.
Vector3d shortestDifference(std::span<const Vector3d> pull, std::span<const Vector3d> push) {
  Vector3d g = pull[0] - push[0], last = g;
  for (int k = 0; k < kGilbertSteps; ++k) {
    const Vector3d w = pull[minAlong(g, pull)] - push[minAlong(-g, push)];
    const double gain = g.squaredNorm() - g.dot(w);
    if (gain <= kGilbertGap * g.squaredNorm() || g.squaredNorm() < kFlat * kFlat) break;
    if (k == 0)
      g += std::min(1.0, gain / (g - w).squaredNorm()) * (w - g);
    else
      g = nearestOnTriangle(Vector3d::Zero(), g, last, w).point;
    last = w;
  }
  return g;
}

// The nearest point, whose distance is known to be at most `bound` up to rounding. If rounding makes the bounded search
// return nothing, as it can far from the origin of coordinates, searches again without a bound.
NearestPoint nearestWithin(const DistanceField& field, const Vector3d& p, double bound) {
  const NearestPoint found = field.nearest(p, bound * (1 + 1e-9) + std::numeric_limits<double>::min());
  return std::isfinite(found.distance) ? found : field.nearest(p);
}

/// Points of the surface found so far; of more than kMaxNear, the oldest is replaced.
class NearPoints {
 public:
  void remember(const NearestPoint& s, bool inside) {
    points_[next_] = {s.point, s.slack, inside ? 1.0 : -1.0};
    next_ = (next_ + 1) % kMaxNear;
    count_ = std::min(count_ + 1, kMaxNear);
  }
  /// No clearance of a ball at `centre` is larger.
  double limit(const Vector3d& centre) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < count_; ++k) least = std::min(least, (centre - points_[k].point).norm() + points_[k].slack);
    return least;
  }
  /// Unit gradients of the clearance for the points nearer than `reach`.
  std::size_t gradients(const Vector3d& centre, double reach, std::array<Vector3d, kMaxNear>& out) const {
    std::size_t count = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      const double d = (centre - points_[k].point).norm();
      if (d + points_[k].slack <= reach && d > 0) out[count++] = points_[k].away * (centre - points_[k].point) / d;
    }
    return count;
  }

 private:
  struct Point {
    Vector3d point;
    double slack, away;  // 1: the clearance increases away from it; -1: it increases towards it, for a centre outside
  };
  std::array<Point, kMaxNear> points_;
  std::size_t count_ = 0, next_ = 0;
};

}  // namespace

double farthest(std::span<const Vector3d> points, const Vector3d& centre) {
  double largest = 0;
  for (const Vector3d& p : points) largest = std::max(largest, (p - centre).squaredNorm());
  return std::sqrt(largest);
}

Refit refitBall(const DistanceField& field, std::span<const Vector3d> patch, const Vector3d& start, double clearance, double first_step,
                int max_steps, double target) {
  Refit best{start, clearance, farthest(patch, start) - clearance};
  if (patch.empty()) return best;
  double reach = best.stand_off + clearance;
  if (best.stand_off <= target) return best;
  NearPoints near;
  near.remember(nearestWithin(field, start, std::abs(clearance)), clearance > 0);

  std::array<Vector3d, kMaxFar> pull;
  std::array<Vector3d, kMaxNear> push;
  double step = first_step;
  const double smallest = kSmallestStep * first_step;
  for (int i = 0; i < max_steps && step > smallest && best.stand_off > target; ++i) {
    // Unit gradients of |p - c| for the farthest patch points and of d for the nearest surface points, with a tolerance
    // of `step`.
    std::size_t pulls = 0;
    const double active2 = (reach - kActive * step) * (reach - kActive * step);
    for (const Vector3d& p : patch) {
      const double d2 = (best.centre - p).squaredNorm();
      if ((d2 >= active2 || reach <= kActive * step) && d2 > 0 && pulls < kMaxFar) pull[pulls++] = (best.centre - p) / std::sqrt(d2);
    }
    const std::size_t pushes = near.gradients(best.centre, std::abs(best.clearance) + kActive * step, push);
    if (pulls == 0 || pushes == 0) break;
    const Vector3d g = shortestDifference({pull.data(), pulls}, {push.data(), pushes});
    const double slope = g.norm();
    if (slope < kFlat) {
      step *= kFlatStep;
      continue;
    }
    const Vector3d trial = best.centre - (step / slope) * g;
    const double limit = near.limit(trial);
    const double trial_reach = farthest(patch, trial);
    best.work += patch.size();
    if (trial_reach - limit >= best.stand_off) {  // the clearance is at most `limit`: no distance query is needed
      step *= kFailedStep;
      continue;
    }
    const NearestPoint touch = nearestWithin(field, trial, limit);
    const bool inside = field.isInside(trial, touch);
    const double trial_clearance = inside ? touch.distance : -touch.distance;
    near.remember(touch, inside);
    best.work += touch.tested;
    if (trial_reach - trial_clearance < best.stand_off) {
      best = {trial, trial_clearance, trial_reach - trial_clearance, best.work};
      reach = trial_reach;
      step *= kGoodStep;
    } else {
      step *= kFailedStep;
    }
  }
  return best;
}

}  // namespace spheretree::builder
