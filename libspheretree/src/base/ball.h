// SPDX-License-Identifier: GPL-3.0-or-later
// Balls in double precision, as the builders use them before a level is certified and rounded to Sphere.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <vector>

#include "spheretree/core/none.h"
#include "spheretree/core/sphere.h"

namespace spheretree::builder {

using spheretree::Ball;  // in the frame of the mesh

/// A ball with the distance that bounds its overhang.
struct FittedBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;     // [mm]
  double clearance = 0;  // distance from the centre to the surface, negative outside the solid [mm]
  /// No point of the ball lies farther outside the solid than this [mm].
  double overhang() const { return radius - clearance; }
  Ball ball() const { return {centre, radius}; }
};

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The result of a builder before the final steps: the balls of each level. Level 0 is one ball. A node without a child
/// on the next level is a leaf and represents its part of the surface on all deeper levels.
struct LevelBalls {
  std::vector<std::vector<Ball>> balls;  // (levels)(nodes of the level)
  /// (levels)(nodes): index of the parent on the level above; kNone on level 0. If the whole vector is empty, the
  /// levels were built independently of each other, and hierarchy.h chooses the grouping.
  std::vector<std::vector<std::uint32_t>> parents;
};

}  // namespace spheretree::builder
