// SPDX-License-Identifier: GPL-3.0-or-later
// Directions from the borders of regions into the solid. Units: mm.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "split/region_borders.h"

namespace spheretree::builder {

/// A straight step from a border vertex into the solid.
struct InwardStep {
  std::uint32_t vertex;
  double length;              // half of a mean border edge, the same for all steps [mm]
  Eigen::Vector3d direction;  // unit vector
};

/// One step for each vertex on the borders between regions. A border vertex lies within an edge or a triangle of the
/// scan, so at most two planes meet there, and the bisector of the angle between them points inside. The directions are
/// smoothed along the borders, as far as they still point inside. `up`: unit vector; steps go against it where the two
/// planes are opposite to each other.
std::vector<InwardStep> findInwardSteps(const TriangleMesh& mesh, const RegionBorders& borders, const Eigen::Vector3d& up);

}  // namespace spheretree::builder
