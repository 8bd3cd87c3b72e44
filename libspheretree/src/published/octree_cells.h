// SPDX-License-Identifier: GPL-3.0-or-later
// The cells of an octree with the surface in them. Units: mm, frame of the mesh.
// Deterministic.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

using Polygon = std::vector<Eigen::Vector3d>;  // flat and convex

struct OctreeCell {
  Eigen::AlignedBox3d box;
  std::vector<Polygon> pieces;  // of the triangles of the mesh
  std::uint32_t parent = kNone;
};

/// The cube about the middle of the bounding box, as wide as its longest side, with all triangles of the mesh.
OctreeCell rootCell(const TriangleMesh& mesh, const DistanceField& field);

/// The halves that contain any piece. `axis`: 0 to 2, across which the box is halved; pieces are cut there, and both
/// parts get exactly the same corners.
std::vector<OctreeCell> halve(const OctreeCell& whole, int axis);

}  // namespace spheretree::builder
