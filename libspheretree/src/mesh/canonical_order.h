// SPDX-License-Identifier: GPL-3.0-or-later
// A canonical order of vertices and triangles, since a tree must not depend on the order in the mesh file.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct OrderedMesh {
  TriangleMesh mesh;                    // the same triangles, without parts
  std::vector<std::uint32_t> triangle;  // (triangles) index in the given mesh
  std::vector<std::uint32_t> vertex;    // (vertices) index in the given mesh
};

/// Orders vertices by their coordinates. Triangles start at their first vertex and follow a Z-curve through their
/// centroids, so that neighbours on the surface are neighbours in the list, which stratified sampling needs. Scaling by
/// a power of two does not change the order. Vertices at the same position keep their relative order. Cost: O(n log n).
/// The curve: G. M. Morton. A computer oriented geodetic data base. IBM, 1966.
OrderedMesh inCanonicalOrder(const TriangleMesh& mesh);

/// The place of a point of `box` on that curve: points in a row are mostly neighbours.
std::uint64_t placeOnCurve(const Eigen::Vector3d& p, const Eigen::AlignedBox3d& box);

}  // namespace spheretree::builder
