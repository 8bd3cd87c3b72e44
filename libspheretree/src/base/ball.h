// SPDX-License-Identifier: GPL-3.0-or-later
// Balls in double precision: what the builders work with before a level is certified and rounded to Sphere.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <limits>
#include <vector>

namespace spheretree::builder {

struct Ball {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // [mm], frame of the mesh
  double radius = 0;                                 // [mm]
};

/// A ball with what bounds its overhang.
struct FittedBall {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0;     // [mm]
  double clearance = 0;  // distance from the centre to the surface, negative outside the solid [mm]
  /// No point of the ball lies farther outside the solid than this [mm].
  double overhang() const { return radius - clearance; }
  Ball ball() const { return {centre, radius}; }
};

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr std::uint32_t kNoParent = std::numeric_limits<std::uint32_t>::max();

/// What a builder hands to the final steps: the balls of each level. A node without a child on the next level ends
/// early and stands for its part at all deeper levels. Level 0 is one ball.
struct LevelBalls {
  std::vector<std::vector<Ball>> balls;  // (levels)(nodes of the level)
  /// (levels)(nodes): index of the parent on the level above; kNoParent on level 0. Empty as a whole: the levels were
  /// made independently of each other, and hierarchy.h chooses the grouping.
  std::vector<std::vector<std::uint32_t>> parents;
};

}  // namespace spheretree::builder
