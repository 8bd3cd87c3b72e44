// SPDX-License-Identifier: GPL-3.0-or-later
// The inside of a closed surface shared out among the regions on it: walls between neighbours, caps under the rest.
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "split/scan_surface.h"

namespace spheretree::builder {

/// Triangles within the surface. `above` is the region on whose side of them they are wound outward; those of the
/// region `below` run the other way.
struct InnerWall {
  std::int32_t above = 0, below = 0;
  std::vector<Triangle> triangles;
};

struct PartSolids {
  std::vector<InnerWall> walls;    // vertices were added to the surface
  std::vector<double> rim_length;  // of the border of each region on the surface [mm]
};

struct WallSettings {
  Eigen::Vector3d up;  // unit vector
  double root_mm = 0;  // > 0: stubs of this length in place of caps
};

/// Every region but the gum is closed by walls: where two of them meet along an arc, a window below the arc down to the
/// straight line between its ends, or no window where the arc is as low as that line; and a cap that spans the rest of
/// the border and these lines, with the gum below it. Each wall belongs to both of its regions, so that the solids fill
/// the surface without gap or overlap wherever no wall crosses another or the surface.
/// @pre closed and manifold, cut.
PartSolids findWalls(ScanSurface& surface, const WallSettings& settings);

/// The solid of a region. `is_invented` follows.
TriangleMesh solidOf(const ScanSurface& surface, const PartSolids& solids, std::int32_t region, std::vector<char>& is_invented);

}  // namespace spheretree::builder
