// SPDX-License-Identifier: GPL-3.0-or-later
// The union of a set of balls, such as the level set of a tree: the distance of a point from it, and the parts of the
// balls' surfaces that bound it.
// Immutable after construction, so that any number of threads may query it. Units: mm.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/box_tree.h"

namespace spheretree::builder {

class SphereUnion {
 public:
  /// Equal balls are stored once, under the lowest index. O(n log n + overlapping pairs).
  /// @throws std::invalid_argument for a ball that is not finite or whose radius is not above 0.
  explicit SphereUnion(std::span<const Ball> balls);

  const std::vector<Ball>& balls() const { return balls_; }
  std::size_t size() const { return balls_.size(); }
  /// Index of ball `i` in the span given to the constructor.
  std::uint32_t source(std::size_t i) const { return source_[i]; }
  const Eigen::AlignedBox3d& box() const { return box_; }

  struct Nearest {
    double gap = std::numeric_limits<double>::infinity();  // min of |p - c| - r: the distance to the union if p is outside [mm]
    std::uint32_t ball = 0;                                // ball of this minimum; on ties the lower index
  };
  Nearest nearest(const Eigen::Vector3d& p) const;
  /// Whether some ball has a distance of at most `tolerance` (>= 0) from `p`.
  bool covers(const Eigen::Vector3d& p, double tolerance = 0) const;

  /// The part of a ball's surface that another ball covers: the unit directions u from the ball's centre with u . axis
  /// > cosine.
  struct Cap {
    Eigen::Vector3d axis;
    double cosine;     // of the circle in which the two surfaces meet; below -1: the whole surface is covered
    double threshold;  // `cosine` with a margin: directions above it are inside the other ball, whatever the rounding
    std::uint32_t other;
  };
  /// Caps of ball `i`, largest first. A ball inside ball `i` makes none.
  std::span<const Cap> caps(std::size_t i) const { return {caps_.data() + first_cap_[i], caps_.data() + first_cap_[i + 1]}; }
  /// True if no part of ball `i`'s surface bounds the union.
  bool isHidden(std::size_t i) const { return !caps(i).empty() && caps(i).front().threshold < -1; }
  /// The largest cap of ball `i` that contains the unit direction `u`; null if there is none: then that point bounds
  /// the union. A point that is inside another ball by less than 1e-11 of the largest coordinate counts as a point of
  /// the boundary.
  const Cap* capOver(std::size_t i, const Eigen::Vector3d& u) const;
  /// Whether the whole spherical triangle a, b, c (unit directions) of ball `i` is proven to lie in one cap.
  /// `flatness`: a lower bound, > 0, of the distance of the flat triangle from the centre of the unit sphere.
  bool isBuried(std::size_t i, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c, double flatness) const;

 private:
  std::vector<Ball> balls_;
  std::vector<std::uint32_t> source_;
  BoxTree tree_;
  std::vector<std::uint32_t> first_cap_;  // (size + 1)
  std::vector<Cap> caps_;
  Eigen::AlignedBox3d box_;
};

}  // namespace spheretree::builder
