// SPDX-License-Identifier: GPL-3.0-or-later
// Area of triangles of a mesh [mm^2].
#pragma once

#include <Eigen/Geometry>
#include <cstddef>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline double triangleArea(const TriangleMesh& mesh, std::size_t triangle) {
  return 0.5 * (mesh.corner(triangle, 1) - mesh.corner(triangle, 0)).cross(mesh.corner(triangle, 2) - mesh.corner(triangle, 0)).norm();
}

inline double surfaceArea(const TriangleMesh& mesh) {
  double area = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area += triangleArea(mesh, t);
  return area;
}

}  // namespace spheretree::builder
