// SPDX-License-Identifier: GPL-3.0-or-later
// The surface that a tree represents: the surface of a solid, and sheets outside it. Sheets are input with nothing
// solid on either side that repair cannot make part of a solid. They are covered like the rest, and a sphere on a sheet
// has an overhang of at most its radius.
#pragma once

#include "geometry/distance_field.h"

namespace spheretree::builder {

struct SurfaceWithSheets {
  TriangleMesh sheets;
  DistanceField field;  // of the solid and the sheets
};

/// Triangles of `cover_too` (repair_mesh.h's `to_cover`) become sheets if a corner or the centroid lies outside `solid`
/// by more than 1e-5 of its diagonal; the others are dropped. Cost: a distance query for each of those points, and one
/// field, or two if there are sheets.
SurfaceWithSheets surfaceWithSheets(const TriangleMesh& solid, const TriangleMesh& cover_too);

}  // namespace spheretree::builder
