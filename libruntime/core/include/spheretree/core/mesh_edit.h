// SPDX-License-Identifier: Apache-2.0
// Edits of triangle meshes that several rooms need.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree {

inline constexpr std::uint32_t kNoVertex = std::numeric_limits<std::uint32_t>::max();

/// Leaves out the vertices that no triangle has; the others keep their order. Triangles must name vertices that exist.
void dropUnusedVertices(TriangleMesh& mesh);

/// Vertices at exactly equal positions become one, the first of them, and vertices that no triangle has are left out;
/// the others keep their order. Triangles must name vertices that exist. Returns the new index of each old vertex,
/// kNoVertex where no triangle had it. Cost: O(size of the mesh); 12 bytes more for each vertex while it runs.
std::vector<std::uint32_t> weldEqualVertices(TriangleMesh& mesh);

/// The triangles of `mesh`, then those of `more`, each with its own vertices; without parts.
TriangleMesh joined(TriangleMesh mesh, const TriangleMesh& more);

}  // namespace spheretree
