// SPDX-License-Identifier: GPL-3.0-or-later
// Hulls of one, two or three numbered balls, with an estimate of how far they reach out of the solid, and those that
// the regular triangulation of the balls proposes. Such hulls as parts of a shape: P. Li, B. Wang, F. Sun, X. Guo,
// C. Zhang, W. Wang. Q-MAT. ACM TOG 35(1), 2015. docs/algorithms/hulls/fit_hulls.md
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "geometry/hull.h"

namespace spheretree::builder {

/// A ball, a cone or a slab.
struct Simplex {
  std::array<std::uint32_t, 3> corner{};  // balls, ascending, `hull.count` of them
  Hull hull{};                            // of the inscribed balls
  double overhang = 0;                    // of the hull, about [mm]
  std::optional<HullDistance> distance{};
  std::vector<std::uint32_t> samples{};  // that it holds best
  bool is_alive = true;
  std::span<const std::uint32_t> corners() const { return {corner.data(), hull.count}; }
  /// How far the hull has to grow to hold the point, plus its overhang [mm].
  double costOf(const Eigen::Vector3d& p) const { return std::max(0.0, (*distance)(p)) + overhang; }
  bool has(std::uint32_t v) const { return std::ranges::find(corners(), v) != corners().end(); }
  bool isIn(const Simplex& other) const {
    return std::ranges::all_of(corners(), [&](std::uint32_t v) { return other.has(v); });
  }
};

struct NumberedBall {
  std::uint32_t number;
  Ball ball;
};

/// The hull of one to three balls if its overhang is at most `limit` [mm] and it is neither thin nor steep; else those
/// of its sides.
std::vector<Simplex> simplicesOf(const DistanceField& field, std::vector<NumberedBall> corners, double limit);

/// Those of all triangles, sides and corners of the regular triangulation of the balls; none is in another. Ordered by
/// their corners, those with the most first.
std::vector<Simplex> triangulated(const DistanceField& field, std::span<const Ball> balls, double limit);

}  // namespace spheretree::builder
