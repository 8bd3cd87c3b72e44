// SPDX-License-Identifier: GPL-3.0-or-later
// Keeps the balls of a search near the surface, as a tree for soft tissue needs them.
//
// A ball that covers two opposite sides of a body protrudes by about strain times radius when the body is compressed.
// Leaves for tissue are therefore limited to a share of the radius of the largest ball that touches the surface where
// they do. A sheet inside the solid, at twice that depth, enforces this in every search that uses the distance to the
// surface: no ball between sheet and surface is larger.
// Units: those of the mesh.
#pragma once

#include "geometry/distance_field.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// A sheet for a DistanceField. Below each point p of the surface, with its inward normal n, it lies at p + 2 share t
/// n, where t is the depth of the centre of the largest ball below p that is inside the solid and at most `stand_off`
/// from p. `share`: (0, 0.5]; at 0.5 the sheet is approximately the medial axis. `field` is that of `mesh`. Triangles
/// with sides longer than `spacing` are subdivided first. Deterministic for any number of threads.
/// Cost: about ten distance queries for each corner of a triangle.
TriangleMesh innerSheet(const TriangleMesh& mesh, const DistanceField& field, double share, double stand_off, double spacing);

}  // namespace spheretree::builder
