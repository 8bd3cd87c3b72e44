// SPDX-License-Identifier: Apache-2.0
// Edits of triangle meshes that several rooms need.
#pragma once

#include <cstdint>
#include <vector>

#include "spheretree/core/none.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree {

/// Removes the vertices that no triangle uses; the others keep their order. All vertex indices must be in range.
void dropUnusedVertices(TriangleMesh& mesh);

/// Merges vertices at exactly equal positions into the first of them, and removes the vertices that no triangle uses;
/// the others keep their order. All vertex indices must be in range. Returns the new index of each old vertex, or
/// kNone if no triangle used it. Cost: O(size of the mesh), and 12 bytes of temporary memory for each vertex.
std::vector<std::uint32_t> weldEqualVertices(TriangleMesh& mesh);

/// The triangles of `mesh`, then those of `more`, each with its own vertices. The result has no parts.
TriangleMesh joined(TriangleMesh mesh, const TriangleMesh& more);

}  // namespace spheretree
