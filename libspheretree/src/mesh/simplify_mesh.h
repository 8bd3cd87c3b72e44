// SPDX-License-Identifier: GPL-3.0-or-later
// Fewer triangles for the search: a mesh far finer than what the spheres can follow is thinned first. What a build
// states is still proven against every triangle of the mesh that was given; docs/algorithms/mesh/simplify_mesh.md
//
// Half-edge collapses in the order of their quadric error, on the connectivity of OpenMesh, in rounds of collapses that
// do not touch each other. Paper: M. Garland, P. Heckbert. Surface simplification using quadric error metrics. SIGGRAPH
// 1997. Not OpenMesh's own decimater: it takes 40 s for a million triangles where the rounds take 3.
#pragma once

#include <cstddef>
#include <limits>

#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A mesh of at most `triangles` triangles or little more, near `mesh`: where every further collapse would turn a
/// triangle over, make a sliver or change the topology, it ends earlier. Its vertices are vertices of `mesh`, in their
/// order; parts are dropped. Closed, oriented and manifold as `mesh` is; it may cross itself in walls thinner than its
/// triangles.
/// `max_error` [mm]: no collapse moves a vertex to where the root of the mean squared distance to its planes is larger;
/// then it ends earlier, too.
/// Deterministic for any number of threads. Cost: O(n log n), about 3 s of processor time for a million triangles.
/// @throws Cancelled, std::invalid_argument for a mesh that is not manifold.
TriangleMesh simplifyMesh(const TriangleMesh& mesh, std::size_t triangles, Progress& progress,
                          double max_error = std::numeric_limits<double>::infinity());

/// Proven: no point of `mesh` is farther from the surface of `field` than this [mm]. At most a quarter above the
/// largest distance of a vertex, or 1e-6 of the diagonal, whichever is more, unless that takes more than 1024 pieces
/// for a triangle; then still proven.
/// Cost: one distance query for each vertex, and a few pieces for each triangle that bends over an edge of the other
/// surface. With `sufficient_bound`, all that is wanted is a bound that is not above it: then the bound is found sooner and may
/// be as large as
/// `sufficient_bound`; infinite if a point was found that is farther. Deterministic for any number of threads. @throws Cancelled.
double distanceBound(const TriangleMesh& mesh, const DistanceField& field, Progress& progress,
                     double sufficient_bound = std::numeric_limits<double>::infinity());

}  // namespace spheretree::builder
