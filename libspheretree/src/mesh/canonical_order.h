// SPDX-License-Identifier: GPL-3.0-or-later
// One order of vertices and triangles, whatever the file's: a tree must not depend on who wrote the mesh.
#pragma once

#include <cstdint>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct OrderedMesh {
  TriangleMesh mesh;                    // the same triangles; parts are left out
  std::vector<std::uint32_t> triangle;  // (triangles) index in the mesh given
};

/// Vertices by their coordinates; triangles start at their first vertex and follow a Z-curve through their centroids,
/// so that neighbours on the surface are neighbours in the list, which stratified sampling needs. Scaling by a power of
/// two changes nothing. Positions that several vertices share keep their order among each other. Cost: O(n log n).
/// The curve: G. M. Morton. A computer oriented geodetic data base. IBM, 1966.
OrderedMesh inCanonicalOrder(const TriangleMesh& mesh);

}  // namespace spheretree::builder
