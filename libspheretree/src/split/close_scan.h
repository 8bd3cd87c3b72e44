// SPDX-License-Identifier: GPL-3.0-or-later
// Closes a scan below its outer border by a wall down to a base plane. Units: mm.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "split/scan_surface.h"

namespace spheretree::builder {

/// The longest border loop of the connected component with the largest area, as returned by findHoleLoops(); empty if
/// the component is closed.
std::vector<std::uint32_t> findOuterLoop(const TriangleMesh& mesh);

/// Removes triangles of the scan near its outer border until the wall and base of addBase() cross nothing there. Call
/// it before the holes are filled. @pre manifold.
void clearBase(ScanSurface& surface, const Eigen::Vector3d& up, double depth);

/// Adds the wall and the base below the only remaining border loop, as gum. The base plane is perpendicular to `up`, a
/// unit vector, and `depth` below the lowest point of the surface. The outline of the base is the border projected
/// along `up`, smoothed until it does not cross itself. Adds nothing if there is no border. Call it after the cut.
void addBase(ScanSurface& surface, const Eigen::Vector3d& up, double depth);

}  // namespace spheretree::builder
