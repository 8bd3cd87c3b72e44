// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/inscribed_ball.h"

#include <Eigen/Geometry>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr double kDeeper = 1.3;     // factor from depth to depth below a point of the surface
constexpr int kHalvings = 7;        // of the search for a depth
constexpr double kPull = 0.2;       // of the gap, against the radius, while balls are centred
constexpr double kLastMove = 1e-3;  // last step of the centring, as a share of the radius
constexpr int kMoves = 3;           // at most, of each length

// Across: towards the nearest surface. Along: towards the point, as far as that is across the former.
Eigen::Matrix3d axesAt(const DistanceField& field, const Ball& ball, const Vector3d& point) {
  const Vector3d out = field.nearest(ball.centre).point - ball.centre;
  if (!(out.norm() > 0)) return Eigen::Matrix3d::Identity();
  return axesFrom(out.normalized(), point - ball.centre, kThinnest * ball.radius);
}

}  // namespace

Ball ballBelow(const DistanceField& field, const Vector3d& point, const Vector3d& normal, double gap) {
  Ball best{point, 0};
  const auto reaches = [&](double depth) {
    const Vector3d c = point - depth * normal;
    const double radius = -field.signedDistance(c);
    if (!(radius >= depth - gap && radius > 0)) return false;
    best = {c, radius};
    return true;
  };
  double low = gap, high = kDeeper * low;
  while (reaches(high)) low = high, high *= kDeeper;
  for (int halving = 0; halving < kHalvings; ++halving) {
    const double middle = 0.5 * (low + high);
    (reaches(middle) ? low : high) = middle;
  }
  return best;
}

Ball centred(const DistanceField& field, Ball ball, const Vector3d& point, double gap) {
  const auto valueOf = [&](const Ball& b) { return (1 + kPull) * b.radius - kPull * (point - b.centre).norm(); };
  for (double step = kFirstMove; step > kLastMove; step *= 0.5)
    for (int move = 0; move < kMoves; ++move) {
      const Eigen::Matrix3d axes = axesAt(field, ball, point);
      Ball best = ball;
      for (Eigen::Index axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0}) {
          const Vector3d c = ball.centre + sign * step * ball.radius * axes.col(axis);
          const Ball moved{c, -field.signedDistance(c)};
          if (valueOf(moved) > valueOf(best) && (point - c).norm() - moved.radius <= gap) best = moved;
        }
      if (best.centre == ball.centre) break;
      ball = best;
    }
  return ball;
}

Eigen::Matrix3d axesFrom(const Vector3d& unit, const Vector3d& other, double shortest) {
  Vector3d across = other - other.dot(unit) * unit;
  across = across.norm() > shortest ? across.normalized() : unit.unitOrthogonal();
  Eigen::Matrix3d axes;
  axes << unit, across, unit.cross(across);
  return axes;
}

}  // namespace spheretree::builder
