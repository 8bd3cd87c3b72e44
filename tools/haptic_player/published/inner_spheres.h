// SPDX-License-Identifier: GPL-3.0-or-later
// A body filled with spheres that do not overlap, in a hierarchy of balls.
// Paper: R. Weller, G. Zachmann. Inner sphere trees for proximity and penetration queries. Robotics: Science and
// Systems 2009; the packing by prototypes after R. Weller, G. Zachmann. ProtoSphere, SIGGRAPH Asia 2010 Sketches.
// Units: mm, mesh frame.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "published/ball_tree.h"

namespace spheretree::player {

struct Body;

struct InnerSpheres {
  static constexpr std::size_t kBytes = 32;  // of a sphere: four floats, and its share of the hierarchy

  /// Greedy: the largest sphere that fits between the surface and those placed before, found on a grid of places and
  /// grown from the best one (the prototype moves away from what is nearest). Ends at `count` spheres, or once a sphere
  /// would be smaller than a thousandth of the diagonal.
  InnerSpheres(const Body& body, std::size_t count);

  std::vector<Eigen::Vector3d> centre;
  std::vector<double> radius;
  BallTree tree;
};

}  // namespace spheretree::player
