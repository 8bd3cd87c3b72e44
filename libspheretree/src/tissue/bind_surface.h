// SPDX-License-Identifier: GPL-3.0-or-later
// Attaches the vertices of a mesh to tetrahedra that fill the mesh or a simplified form of it.
#pragma once

#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/tissue.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {

/// One entry for each vertex of `mesh`: the tetrahedron that contains it. A vertex outside all tetrahedra, since they
/// fill a simplified surface, is attached to the tetrahedron near it whose map needs the smallest extrapolation. `rest`
/// is relative to `origin`. Deterministic for any number of threads. Cost: O(vertices * log tetrahedra).
std::vector<TissueVertex> bindSurface(const TriangleMesh& mesh, const Tetrahedra& solid, const Eigen::Vector3d& origin, Progress& progress);

}  // namespace spheretree::builder
