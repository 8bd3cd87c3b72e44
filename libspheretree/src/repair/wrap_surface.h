// SPDX-License-Identifier: GPL-3.0-or-later
// A closed, manifold surface round any triangles, that encloses them: what a repair falls back on.
//
// Paper: C. Portaneri, M. Rouxel-Labbe, M. Hemmer, D. Cohen-Steiner, P. Alliez. Alpha wrapping with an offset. ACM TOG
//         41(4), 2022,
// as CGAL has it: a ball of radius alpha rolls up to the triangles from outside, and stops `offset` before them.
// Units: mm. Deterministic.
#pragma once

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Gaps that a ball of radius `alpha` cannot enter are closed, cavities filled; every triangle lies strictly inside.
/// Cost grows as area / alpha^2. @pre at least one triangle, none flat; 0 < offset. @throws Cancelled
TriangleMesh wrapSurface(const TriangleMesh& mesh, double alpha, double offset, const Progress& progress);

}  // namespace spheretree::builder
