// SPDX-License-Identifier: GPL-3.0-or-later
// Cuts a surface along a smooth border between its regions, through its triangles. Units: mm.
#pragma once

#include "split/scan_surface.h"

namespace spheretree::builder {

/// Before: each vertex has a region, and the border runs through the middles of the edges between regions. The border
/// is smoothed and moves by at most `smooth` [mm], and by one edge more where labels are jagged. The triangles are cut
/// along it: new vertices lie on edges of the surface, and, where three regions meet in a triangle, one vertex lies
/// within it. Afterwards each triangle has a region, and new vertices are shared, so that no gap appears. The surface
/// itself does not change. With a `smooth` of 0 the border stays where it is.
///
/// Method: each region has a signed distance to its border, positive within it, at the vertices near it
/// (`findBorderDistances`, which centres jagged borders). Four times the distance is replaced by the value of its best
/// linear fit to the neighbours of a vertex, which preserves straight borders on any triangulation, and clamped to
/// within `smooth` of its original value. A vertex belongs to the region with the largest distance, and an edge is cut
/// where the two largest are equal.
void cutLabels(ScanSurface& surface, double smooth);

}  // namespace spheretree::builder
