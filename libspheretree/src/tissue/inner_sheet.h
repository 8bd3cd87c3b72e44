// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the balls of a search near the surface, as a tree for soft tissue needs them.
//
// A ball that carries two sides of a body sticks out by about strain times radius once the body is squeezed, so leaves
// for tissue are to have at most a share of the radius of the largest ball that touches the surface where they do. A
// sheet inside the solid, at twice that depth, has this effect on every search that asks for the distance to the
// surface: no ball between sheet and surface is larger.
// Units: those of the mesh.
#pragma once

#include "geometry/distance_field.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A sheet for a DistanceField. Under each point p of the surface, with its inward normal n, it lies at
/// p + 2 share t n, where t is the depth of the centre of the largest ball below p that is inside the solid and no
/// farther than `stand_off` from p. `share`: (0, 0.5]; at 0.5 the sheet is about the medial axis. `field`: of `mesh`.
/// Triangles with longer sides than `spacing` are divided first. Deterministic for any number of threads.
/// Cost: about ten distance queries for each corner of a triangle.
TriangleMesh innerSheet(const TriangleMesh& mesh, const DistanceField& field, double share, double stand_off, double spacing);

}  // namespace spheretree::builder
