// SPDX-License-Identifier: Apache-2.0
// A closed mesh of exactly as many triangles as asked for.
#pragma once

#include <cstddef>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::samples {

/// Collapses the shortest edges to their middles until `triangles` are left; each takes two with it, so a closed mesh
/// keeps an even number. An edge stays where its collapse would pinch the surface or fold it. Cost: O(triangles) an
/// edge, for the last few per cent.
/// @throws std::invalid_argument if the mesh has fewer triangles, or an odd number more.
void collapseTo(TriangleMesh& mesh, std::size_t triangles);

}  // namespace spheretree::samples
