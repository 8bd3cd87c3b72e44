// SPDX-License-Identifier: GPL-3.0-or-later
// The part of a soft body that does not move: balls, boxes, and the inside of other objects.
// Units: mm, frame of the mesh.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "spheretree/core/sphere_tree.h"

namespace spheretree::pipeline {

struct FixedRegions {
  std::vector<Sphere> balls;
  std::vector<Eigen::AlignedBox3d> boxes;

  bool empty() const { return balls.empty() && boxes.empty(); }
  bool holds(const Eigen::Vector3d& p) const;
};

/// Adds "sphere:X,Y,Z,RADIUS" or "box:X0,Y0,Z0,X1,Y1,Z1". Returns false for any other text.
bool addFixedRegion(const std::string& text, FixedRegions& regions);

/// Adds the leaves of `tree`, which cover its object's surface.
void addLeaves(const SphereTree& tree, FixedRegions& regions);

}  // namespace spheretree::pipeline
