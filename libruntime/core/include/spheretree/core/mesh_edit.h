// SPDX-License-Identifier: Apache-2.0
// Edits of triangle meshes that several rooms need.
#pragma once

#include "spheretree/core/triangle_mesh.h"

namespace spheretree {

/// Leaves out the vertices that no triangle has; the others keep their order. Triangles must name vertices that exist.
void dropUnusedVertices(TriangleMesh& mesh);

/// The triangles of `mesh`, then those of `more`, each with its own vertices; without parts.
TriangleMesh joined(TriangleMesh mesh, const TriangleMesh& more);

}  // namespace spheretree
