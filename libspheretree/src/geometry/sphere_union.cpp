// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/sphere_union.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <tuple>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Eigen::AlignedBox3d boxOf(const Ball& ball) {
  const Vector3d reach = Vector3d::Constant(ball.radius);
  return {ball.centre - reach, ball.centre + reach};
}

}  // namespace

SphereUnion::SphereUnion(std::span<const Ball> balls) {
  std::vector<std::uint32_t> order(balls.size());
  std::iota(order.begin(), order.end(), 0u);
  for (const std::uint32_t i : order)
    if (!balls[i].centre.allFinite() || !(balls[i].radius > 0) || !std::isfinite(balls[i].radius))
      throw std::invalid_argument("union of balls: ball " + std::to_string(i) + " is not finite or has no radius above 0");
  const auto key = [&](std::uint32_t i) {
    const Ball& b = balls[i];
    return std::make_tuple(b.centre.x(), b.centre.y(), b.centre.z(), b.radius);
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  for (std::size_t i = 0; i < order.size(); ++i)
    if (i == 0 || key(order[i]) != key(order[i - 1])) source_.push_back(order[i]);
  std::sort(source_.begin(), source_.end());

  std::vector<Eigen::AlignedBox3d> boxes;
  for (const std::uint32_t i : source_) {
    balls_.push_back(balls[i]);
    boxes.push_back(boxOf(balls[i]));
    box_.extend(boxes.back());
  }
  tree_ = BoxTree(boxes);

  const double scale = balls_.empty() ? 0 : std::max(box_.min().cwiseAbs().maxCoeff(), box_.max().cwiseAbs().maxCoeff());
  const double margin = 1e-11 * scale;
  first_cap_.push_back(0);
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const Ball& ball = balls_[i];
    tree_.searchWithin(ball.centre, ball.radius * ball.radius, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) {
        const std::uint32_t j = tree_.order()[slot];
        const Ball& other = balls_[j];
        const Vector3d between = other.centre - ball.centre;
        const double d = between.norm();
        if (j == i || d >= ball.radius + other.radius || d + other.radius <= ball.radius) continue;
        if (!(d > 0)) {  // concentric and larger
          caps_.push_back({Vector3d::UnitX(), -2, -2, j});
          continue;
        }
        // |c + r u - c_j|^2 = r^2 + d^2 - 2 r d (u . axis) < r_j^2
        const double squares = ball.radius * ball.radius + d * d, twice = 2 * ball.radius * d;
        const double cosine = (squares - other.radius * other.radius) / twice;
        const double rounding = 2 * other.radius * margin + 16 * kEpsilon * (squares + other.radius * other.radius);
        caps_.push_back({between / d, cosine, cosine + rounding / twice + 1e-15, j});
      }
    });
    std::sort(caps_.begin() + first_cap_.back(), caps_.end(),
              [](const Cap& a, const Cap& b) { return a.cosine != b.cosine ? a.cosine < b.cosine : a.other < b.other; });
    first_cap_.push_back(static_cast<std::uint32_t>(caps_.size()));
  }
}

SphereUnion::Nearest SphereUnion::nearest(const Vector3d& p) const {
  Nearest best;
  double limit2 = std::numeric_limits<double>::infinity();
  tree_.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
    for (std::size_t slot = first; slot < first + count; ++slot) {
      const std::uint32_t i = tree_.order()[slot];
      const double gap = (p - balls_[i].centre).norm() - balls_[i].radius;
      if (gap > best.gap || (gap == best.gap && i >= best.ball)) continue;
      best = {gap, i};
      // Only boxes within this distance can contain a nearer ball; once `p` is inside a ball, only boxes that contain
      // `p`.
      limit2 = gap > 0 ? gap * gap * (1 + 1e-12) : std::numeric_limits<double>::min();
    }
  });
  return best;
}

bool SphereUnion::covers(const Vector3d& p, double tolerance) const {
  bool found = false;
  double limit2 = tolerance * tolerance * (1 + 1e-12) + std::numeric_limits<double>::min();
  tree_.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
    for (std::size_t slot = first; slot < first + count && !found; ++slot) {
      const Ball& ball = balls_[tree_.order()[slot]];
      const double reach = ball.radius + tolerance;
      found = (p - ball.centre).squaredNorm() <= reach * reach;
    }
    if (found) limit2 = -1;  // ends the search
  });
  return found;
}

const SphereUnion::Cap* SphereUnion::capOver(std::size_t i, const Vector3d& u) const {
  for (const Cap& cap : caps(i))
    if (u.dot(cap.axis) > cap.threshold) return &cap;
  return nullptr;
}

bool SphereUnion::isBuried(std::size_t i, const Vector3d& a, const Vector3d& b, const Vector3d& c, double flatness) const {
  for (const Cap& cap : caps(i)) {
    // A point of the spherical triangle is y / |y| with y on the flat triangle, flatness <= |y| <= 1, and y . axis is
    // at least the smallest value at the corners.
    const double smallest = std::min({a.dot(cap.axis), b.dot(cap.axis), c.dot(cap.axis)});
    if ((smallest >= 0 ? smallest : smallest / flatness) > cap.threshold + 1e-14) return true;
  }
  return false;
}

}  // namespace spheretree::builder
