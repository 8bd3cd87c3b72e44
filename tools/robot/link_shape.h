// SPDX-License-Identifier: GPL-3.0-or-later
// The shape of a collision element that is covered by spheres: a ball, which is its own cover, or a mesh.
// Units: mm, frame of the link.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "robot/robot_model.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::robot {

/// A ball in double precision.
struct LinkBall {
  Eigen::Vector3d centre;  // [mm]
  double radius;           // [mm]
};

struct LinkShape {
  std::optional<LinkBall> ball;    // the shape is a ball; then `mesh` is empty
  TriangleMesh mesh;               // closed for primitives; a mesh file unchanged
  double padding = 0;              // the true surface is within this distance of the mesh, for example of a cylinder [mm]
  std::vector<std::string> notes;  // of the reader
};

/// A box has 12 triangles; a cylinder is a prism whose edges lie on it. Mesh files (STL, OBJ, PLY, OFF, glTF, DAE) are
/// in metres; they are scaled first and then placed.
/// @throws formats::FileError, formats::FormatError
LinkShape shapeOf(const CollisionElement& element);

/// Triangles whose vertices lie on the ball, accurate to 0.2 % of its radius.
TriangleMesh ballMesh(const LinkBall& ball);

}  // namespace spheretree::robot
