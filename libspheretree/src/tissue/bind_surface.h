// SPDX-License-Identifier: GPL-3.0-or-later
// Ties the vertices of a mesh to tetrahedra that fill it, or a simplified form of it.
#pragma once

#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/tissue.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {

/// One entry for each vertex of `mesh`: the tetrahedron that holds it. A vertex that none holds, because the
/// tetrahedra fill a simplified surface, is tied to the one near it whose map reaches it with the least extrapolation.
/// `rest` is relative to `origin`. Deterministic for any number of threads. Cost: O(vertices * log tetrahedra).
std::vector<TissueVertex> bindSurface(const TriangleMesh& mesh, const Tetrahedra& solid, const Eigen::Vector3d& origin, Progress& progress);

}  // namespace spheretree::builder
