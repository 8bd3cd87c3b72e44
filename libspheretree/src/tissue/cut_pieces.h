// SPDX-License-Identifier: GPL-3.0-or-later
// Divides a surface among the leaves that cover it: every triangle is cut into convex pieces, each inside one leaf.
//
// The cuts run along planes of equal power of two leaves, as in certify/power_cells.h. Here corners are kept as
// barycentric coordinates of the triangle, so that they can be computed again after the triangle has moved.
#pragma once

#include <span>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Fills `begin`, `corners` (each once for a leaf, ascending) and `cuts` of the result; its anchors stay empty. The
/// pieces of a triangle together are the whole triangle. `leaves` are relative to `origin`. Deterministic for any
/// number of threads. Cost: O(triangles + pieces); a triangle tests the leaves near it.
/// @throws BuildError if the leaves leave more of the surface uncovered than rounding explains; Cancelled.
TissueLeaves cutPieces(const TriangleMesh& mesh, std::span<const Sphere> leaves, const Eigen::Vector3d& origin, Progress& progress);

}  // namespace spheretree::builder
