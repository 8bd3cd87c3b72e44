// SPDX-License-Identifier: GPL-3.0-or-later
// The cells of an octree with the surface in them, and the balls around it. Units: mm, frame of the mesh.
// Deterministic.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline constexpr double kNegligibleOverhang = 1e-6;  // negligible overhang, as a share of the diagonal

using Polygon = std::vector<Eigen::Vector3d>;  // flat and convex

struct OctreeCell {
  Eigen::AlignedBox3d box;
  std::vector<Polygon> pieces;  // of the triangles of the mesh
  std::uint32_t parent = kNoParent;
};

/// The bounding box of the mesh, with all of its triangles.
OctreeCell rootCell(const TriangleMesh& mesh, const DistanceField& field);

Polygon cornersOf(const OctreeCell& cell);

/// The ball about `centre` around `corners`, whose centre is moved to lower the overhang. `corners`: those of the cell.
FittedBall refittedBall(const OctreeCell& cell, const Polygon& corners, const DistanceField& field, const Eigen::Vector3d& centre,
                        double clearance);

/// The one with the smaller overhang.
inline FittedBall better(const FittedBall& a, const FittedBall& b) { return b.overhang() < a.overhang() ? b : a; }

/// The better of two balls: the smallest ball, whose centre lies on the surface where that is flat; and a ball about
/// the middle of the cell, whose centre is then moved.
FittedBall ballRound(const OctreeCell& cell, const DistanceField& field);

/// The halves that contain any piece. `axis`: 0 to 2, across which the box is halved; pieces are cut there, and both
/// parts get exactly the same corners.
std::vector<OctreeCell> halve(const OctreeCell& whole, int axis);

}  // namespace spheretree::builder
