// SPDX-License-Identifier: GPL-3.0-or-later
// Triangles for drawing: corners with normals, smooth except at sharp edges. Units: mm.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "spheretree/core/skin.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::view {

struct SurfaceCorner {
  Eigen::Vector3f position, normal;
};

struct Surface {
  std::vector<SurfaceCorner> corners;
  std::vector<std::uint32_t> indices;  // three for each triangle
  bool empty() const { return indices.empty(); }
};

/// The normal of a corner is the area-weighted mean over its adjacent faces that meet at less than `crease` [rad].
Surface surfaceOf(const TriangleMesh& mesh, double crease = 0.8);

/// The patches, each as four flat triangles through its six nodes, with the normals of the patch, which a tool feels.
Surface surfaceOf(const Skin& skin);

/// Adds a ball of 20 * 4^`rounds` triangles.
void addBall(Surface& surface, const Eigen::Vector3d& centre, double radius, int rounds);

}  // namespace spheretree::view
