// SPDX-License-Identifier: GPL-3.0-or-later
// Closes a scan under its outer border: a wall down to a base plane. Units: mm.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "split/scan_surface.h"

namespace spheretree::builder {

/// The longest border loop of the connected component with the largest area, as findHoleLoops() gives it; empty if it
/// is closed.
std::vector<std::uint32_t> findOuterLoop(const TriangleMesh& mesh);

/// Leaves out triangles of the scan near its outer border until what addBase() puts under it crosses nothing there.
/// Before the holes are filled. @pre manifold.
void clearBase(ScanSurface& surface, const Eigen::Vector3d& up, double depth);

/// Adds the wall and the base under the only border loop that is left, as gum. The base plane is perpendicular to
/// `up`, a unit vector, and `depth` below the lowest point of the surface. The outline of the base is the border seen
/// along `up`, smoothed until it does not cross itself. Nothing is added if there is no border. After the cut.
void addBase(ScanSurface& surface, const Eigen::Vector3d& up, double depth);

}  // namespace spheretree::builder
