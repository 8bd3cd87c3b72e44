// SPDX-License-Identifier: GPL-3.0-or-later
// A closed, manifold surface that encloses any given triangles: the fallback of a repair.
//
// Paper: C. Portaneri, M. Rouxel-Labbe, M. Hemmer, D. Cohen-Steiner, P. Alliez. Alpha wrapping with an offset. ACM TOG
//         41(4), 2022, as implemented in CGAL: a ball of radius alpha rolls up to the triangles from outside, and stops
//         at a distance of `offset`.
// Units: mm. Deterministic.
#pragma once

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Gaps that a ball of radius `alpha` cannot enter are closed, and cavities are filled; every triangle lies strictly
/// inside. Cost: proportional to area / alpha^2. @pre at least one triangle, none flat; 0 < offset. @throws Cancelled
TriangleMesh wrapSurface(const TriangleMesh& mesh, double alpha, double offset, const Progress& progress);

}  // namespace spheretree::builder
