// SPDX-License-Identifier: GPL-3.0-or-later
// Removes crossing triangles from a scan, and fills its holes without new crossings. Units: mm.
#pragma once

#include "split/scan_surface.h"

namespace spheretree::builder {

/// Removes triangles of the scan until no two cross: repeatedly the one with the most crossings, on ties the smallest
/// one. Returns how many. Call it before the holes are filled.
std::size_t dropCrossings(ScanSurface& surface);

/// Fills every border loop with gum, except the longest loop of the largest connected component. A filling crosses
/// neither the scan nor another filling, and uses no edge of the scan except the border. If the triangulation of least
/// bending violates this, a finer one and a fan around the middle of the loop are tried. If these fail, too, the hole
/// is widened: first by the triangles that were crossed, then by rings of triangles. These triangles are lost. Returns
/// the number of filled loops. @pre manifold, without crossings. Call it before the cut.
std::size_t fillScanHoles(ScanSurface& surface);

}  // namespace spheretree::builder
