// SPDX-License-Identifier: GPL-3.0-or-later
// Moves vertices of a noisy scan until its triangles do not cross. Units: mm.
#pragma once

#include "split/scan_surface.h"

namespace spheretree::builder {

struct MovedVertices {
  std::size_t count = 0;
  double mean = 0, farthest = 0;  // distance from the position in the scan [mm]
};

/// Moves the vertices of triangles that cross, towards the mean of their neighbours, by at most three standard
/// deviations of the noise of the scan. Noise turns small triangles over, and smoothing turns them back. Sheets that
/// pass through each other still cross afterwards. The noise is estimated from the roughness of the whole scan.
/// Cost: a search for the crossings of all triangles, then rounds that test only the triangles near the vertices that
/// may move.
MovedVertices untangleScan(ScanSurface& surface);

}  // namespace spheretree::builder
