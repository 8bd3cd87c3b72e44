// SPDX-License-Identifier: GPL-3.0-or-later
// What a tree stands for: the surface of a solid and the sheets outside it, input with nothing solid on either side
// that repair cannot make part of a solid. A sheet is covered like the rest, and a sphere on it reaches out no farther
// than its radius.
#pragma once

#include "geometry/distance_field.h"

namespace spheretree::builder {

struct SurfaceWithSheets {
  TriangleMesh sheets;
  DistanceField field;  // of the solid and the sheets
};

/// Of the triangles `cover_too` (repair_mesh.h's `to_cover`) those are sheets that reach out of `solid`, by more than a
/// hundred-thousandth of its diagonal in a corner or their middle. Cost: a distance query for each of those points, and
/// a field, or two if there are sheets.
SurfaceWithSheets surfaceWithSheets(const TriangleMesh& solid, const TriangleMesh& cover_too);

}  // namespace spheretree::builder
