// SPDX-License-Identifier: GPL-3.0-or-later
// Takes out of a scan what crosses, and fills its holes so that nothing crosses. Units: mm.
#pragma once

#include "split/scan_surface.h"

namespace spheretree::builder {

/// Leaves out triangles of the scan until no two cross: again and again the one that crosses most others, of several
/// the smallest. Returns how many. Before the holes are filled.
std::size_t dropCrossings(ScanSurface& surface);

/// Fills every border loop but the longest of each connected component with gum; of the components other than the
/// largest the longest, too. A filling crosses neither the scan nor another filling and uses no edge of the scan but
/// the border: where the triangulation of least bending does, a finer one and one round the middle of the loop are
/// tried, and then the hole is widened, by what was crossed at first and by rings of triangles after that, which are
/// lost. Returns how many loops it filled. @pre manifold, without crossings. Before the cut.
std::size_t fillScanHoles(ScanSurface& surface);

}  // namespace spheretree::builder
