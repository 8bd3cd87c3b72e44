// SPDX-License-Identifier: Apache-2.0
// Volume and area of a mesh by the simplest formula, and the place of the shared test meshes.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::test {

inline const std::filesystem::path kMeshes = std::filesystem::path(SPHERETREE_SHARED_DIR) / "meshes";

inline double volumeOf(const TriangleMesh& mesh) {
  double sum = 0;
  const Eigen::Vector3d origin = mesh.positions[0];
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    sum += (mesh.corner(t, 0) - origin).dot((mesh.corner(t, 1) - origin).cross(mesh.corner(t, 2) - origin)) / 6;
  return sum;
}

inline double areaOf(const TriangleMesh& mesh) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    sum += (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).norm() / 2;
  return sum;
}

}  // namespace spheretree::test
