// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/smallest_ball.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kMaxPivots = 60;

struct Support {
  std::array<Vector3d, 5> point;
  int size = 0;
};

// The ball with all chosen points on its surface and its centre in their affine hull; false if they are affinely
// dependent.
bool circumBall(const Support& s, const std::array<int, 4>& chosen, int count, Ball& ball) {
  const Vector3d& a = s.point[static_cast<std::size_t>(chosen[0])];
  const auto at = [&](int k) { return Vector3d(s.point[static_cast<std::size_t>(chosen[static_cast<std::size_t>(k)])] - a); };
  Vector3d offset = Vector3d::Zero();
  if (count == 2) {
    offset = 0.5 * at(1);
  } else if (count == 3) {
    const Vector3d u = at(1), v = at(2), w = u.cross(v);
    const double w2 = w.squaredNorm();
    if (!(w2 > 1e-24 * u.squaredNorm() * v.squaredNorm())) return false;
    offset = (u.squaredNorm() * v.cross(w) + v.squaredNorm() * w.cross(u)) / (2 * w2);
  } else if (count == 4) {
    const Vector3d u = at(1), v = at(2), w = at(3);
    const double determinant = u.dot(v.cross(w));
    if (!(std::abs(determinant) > 1e-12 * u.norm() * v.norm() * w.norm())) return false;
    offset = (u.squaredNorm() * v.cross(w) + v.squaredNorm() * w.cross(u) + w.squaredNorm() * u.cross(v)) / (2 * determinant);
  }
  ball = {a + offset, offset.norm()};
  return true;
}

// Smallest ball of at most five points: the smallest circumball of up to four of them that contains all. The last point
// lies outside the smallest ball of the others, and therefore on the surface of the new one. Keeps those points.
bool solve(Support& s, Ball& best) {
  bool found = false;
  std::array<int, 4> best_chosen{};
  int best_count = 0;
  for (unsigned mask = 1u << (s.size - 1); mask < (1u << s.size); ++mask) {
    std::array<int, 4> chosen{};
    int count = 0;
    bool fits = true;
    for (int i = 0; i < s.size; ++i)
      if (mask & (1u << i)) {
        if (count == 4) {
          fits = false;
          break;
        }
        chosen[static_cast<std::size_t>(count++)] = i;
      }
    Ball ball;
    if (!fits || !circumBall(s, chosen, count, ball)) continue;
    if (found && ball.radius >= best.radius) continue;
    const double limit = ball.radius * (1 + 1e-10);
    for (int i = 0; i < s.size && fits; ++i) fits = (s.point[static_cast<std::size_t>(i)] - ball.centre).norm() <= limit;
    if (!fits) continue;
    best = ball, best_chosen = chosen, best_count = count;
    found = true;
  }
  if (!found) return false;
  for (int k = 0; k < best_count; ++k)  // in ascending order, so that nothing is overwritten before it is read
    s.point[static_cast<std::size_t>(k)] = s.point[static_cast<std::size_t>(best_chosen[static_cast<std::size_t>(k)])];
  s.size = best_count;
  return true;
}

}  // namespace

Vector3d circumcentre(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d u = b - a, v = c - a, w = d - a;
  const Vector3d vw = v.cross(w), wu = w.cross(u), uv = u.cross(v);
  const double denominator = 2 * u.dot(vw);
  return a + (u.squaredNorm() * vw + v.squaredNorm() * wu + w.squaredNorm() * uv) / denominator;
}

Ball smallestBall(std::span<const Vector3d> points) {
  if (points.empty()) return {};
  Support support;
  support.point[0] = points.front();
  support.size = 1;
  Ball ball{points.front(), 0};
  const auto farthest = [&] {
    std::size_t at = 0;
    double largest = -1;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double d2 = (points[i] - ball.centre).squaredNorm();
      if (d2 > largest) largest = d2, at = i;
    }
    return std::pair(at, std::sqrt(largest));
  };
  auto [index, reach] = farthest();
  for (int pivot = 0; pivot < kMaxPivots && reach > ball.radius * (1 + 1e-12); ++pivot) {
    Support next = support;
    next.point[static_cast<std::size_t>(next.size++)] = points[index];
    Ball grown;
    if (!solve(next, grown) || !(grown.radius > ball.radius)) break;
    support = next;
    ball = grown;
    std::tie(index, reach) = farthest();
  }
  ball.radius = std::max(ball.radius, reach);
  return ball;
}

}  // namespace spheretree::builder
