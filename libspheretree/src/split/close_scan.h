// SPDX-License-Identifier: GPL-3.0-or-later
// Closes a scan: holes filled, and under its outer border a wall down to a base plane. Units: mm.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "split/scan_surface.h"

namespace spheretree::builder {

/// Leaves out every triangle that crosses another one of the scan. Returns how many. Before the holes are filled.
std::size_t dropCrossings(ScanSurface& surface);

/// Fills every border loop but the longest of each connected component with gum; of the components other than the
/// largest the longest, too. A filling that crosses the scan or itself is made again after the hole was widened by a
/// ring of triangles there, which are lost. Returns how many loops it filled. @pre manifold. Before the cut.
std::size_t fillScanHoles(ScanSurface& surface);

/// Adds the wall and the base under the only border loop that is left, as gum. The base plane is perpendicular to
/// `up`, a unit vector, and `depth` below the lowest point of the surface. The outline of the base is the border seen
/// along `up`, smoothed until it does not cross itself. Nothing is added if there is no border. After the cut.
void addBase(ScanSurface& surface, const Eigen::Vector3d& up, double depth);

}  // namespace spheretree::builder
