// SPDX-License-Identifier: GPL-3.0-or-later
// A body filled with non-overlapping spheres, in a hierarchy of balls.
// Paper: R. Weller, G. Zachmann. Inner sphere trees for proximity and penetration queries. Robotics: Science and
// Systems 2009; the packing by prototypes after R. Weller, G. Zachmann. ProtoSphere, SIGGRAPH Asia 2010 Sketches.
// Units: mm, mesh frame.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "published/ball_tree.h"

namespace spheretree::player {

struct InnerSpheres {
  static constexpr std::size_t kBytes = 32;  // of a sphere: four floats, and its share of the hierarchy

  /// Greedy: repeatedly places the largest sphere that fits between the surface and the spheres placed before. It is
  /// searched on a grid of positions and grown from the best one (the prototype moves away from the nearest obstacle).
  /// Ends at `count` spheres, or when the next sphere would be smaller than 1/1000 of the diagonal.
  InnerSpheres(const Body& body, std::size_t count);

  std::vector<Eigen::Vector3d> centre;
  std::vector<double> radius;
  BallTree tree;
};

}  // namespace spheretree::player
