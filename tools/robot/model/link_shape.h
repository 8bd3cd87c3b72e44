// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of a collision element that is covered by spheres: a capsule, whose cover is computed exactly, or a mesh.
// Units: mm, frame of the link.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "robot/model/robot_model.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::robot {

/// A ball in double precision.
struct LinkBall {
  Eigen::Vector3d centre;  // [mm]
  double radius;           // [mm]
};

/// All points within `radius` of the segment from a to b; a ball if they are equal.
struct LinkCapsule {
  Eigen::Vector3d a, b;  // [mm]
  double radius;         // [mm]
};

struct LinkShape {
  std::optional<LinkCapsule> capsule;  // a capsule or ball; then `mesh` is empty
  TriangleMesh mesh;                   // closed for primitives; a mesh file unchanged
  double padding = 0;                  // the true surface is within this distance of the mesh, for example of a cylinder [mm]
  std::vector<std::string> notes;      // of the reader
  /// False for placeholders: a size of 0, a mesh file without a triangle or without area.
  bool hasSurface() const;
};

/// A box has 12 triangles; a cylinder is a prism whose edges lie on it. The numbers of mesh files (STL, OBJ, PLY, OFF,
/// glTF, DAE) are of the unit `unit_mm` [mm]; they are scaled first and then placed.
/// @throws formats::FileError, formats::FormatError
LinkShape shapeOf(const CollisionElement& element, double unit_mm = 1000);

/// Triangles whose vertices lie on the capsule, accurate to 0.2 % of its radius.
TriangleMesh capsuleMesh(const LinkCapsule& capsule);

}  // namespace spheretree::robot
