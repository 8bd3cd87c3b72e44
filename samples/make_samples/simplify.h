// SPDX-License-Identifier: Apache-2.0
// A closed mesh with a given number of triangles.
#pragma once

#include <cstddef>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::samples {

/// Collapses the shortest edges to their midpoints until `triangles` are left; each collapse removes two, so a closed
/// mesh keeps an even number. An edge stays if its collapse would pinch or fold the surface. Cost: O(triangles) for
/// each edge, for the last few per cent.
/// @throws std::invalid_argument if the mesh has fewer triangles, or if the difference is odd.
void collapseTo(TriangleMesh& mesh, std::size_t triangles);

}  // namespace spheretree::samples
