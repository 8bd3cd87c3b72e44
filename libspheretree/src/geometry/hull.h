// SPDX-License-Identifier: GPL-3.0-or-later
// The convex hull of one, two or three balls: a ball, a rounded cone or a slab. core/hulls.h says which balls it is the
// union of.
// Units: mm.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>

#include "base/ball.h"
#include "spheretree/core/hulls.h"

namespace spheretree::builder {

struct Hull {
  std::array<Ball, 3> ball;
  std::size_t count = 1;  // 1 .. 3
};

inline double steepness(const Hull& hull) { return spheretree::steepness({hull.ball.data(), hull.count}); }

/// All radii larger by this length [mm].
inline Hull grownBy(Hull hull, double by) {
  for (std::size_t k = 0; k < hull.count; ++k) hull.ball[k].radius += by;
  return hull;
}

Eigen::AlignedBox3d boxOf(const Hull& hull);

/// Distance from points to a hull, in closed form.
///
/// With f(w) = |p - c(w)| - r(w) for weights w, the distance is the minimum of f, which is convex. On the line through
/// the centres of a cone, the minimum is where the line from p to c(w) is perpendicular to the cone's side; on the
/// plane of a slab, where it is perpendicular to the slab's face. Beyond the ends it lies at the ends.
class HullDistance {
 public:
  explicit HullDistance(const Hull& hull);
  /// Positive outside, negative inside: then some ball of the hull holds the ball about p with this radius. The value
  /// is f at some weights, so that rounding cannot place a point inside that is outside by more than 1e-14 of its
  /// distance from the balls.
  double operator()(const Eigen::Vector3d& p) const;
  /// Whether the hull holds the whole ball.
  bool holds(const Ball& ball) const { return (*this)(ball.centre) <= -ball.radius; }

 private:
  struct Side {
    Eigen::Vector3d from, along;  // centre of its first ball; unit, to the second
    double length, radius, slope, shift;
    double distance(const Eigen::Vector3d& p) const;
  };
  static Side sideOf(const Ball& a, const Ball& b);

  std::array<Side, 3> side_;
  std::size_t sides_;
  bool is_slab_ = false;
  Eigen::Vector3d corner_, normal_, slope_, shift_, weight1_, weight2_;
  double radius_ = 0, cosine_ = 0;
};

}  // namespace spheretree::builder
