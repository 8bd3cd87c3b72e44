// SPDX-License-Identifier: GPL-3.0-or-later
// Divides the inside of a closed surface among its regions: walls between neighbours, caps below the rest.
// Units: mm.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "split/scan_surface.h"
#include "split/wall_set.h"

namespace spheretree::builder {

struct PartSolids {
  std::vector<InnerWall> walls;        // their new vertices were added to the surface
  std::vector<double> rim_length;      // of the border of each region on the surface [mm]
  std::vector<double> short_roots;     // lengths of the stubs that are shorter than asked for; 0: a cap instead [mm]
  std::vector<std::uint32_t> crossed;  // triangles of the surface that a wall crosses, because no attempt avoided them; ascending
};

struct WallSettings {
  Eigen::Vector3d up;  // unit vector
  double root_mm = 0;  // > 0: stubs of this length instead of caps, or shorter ones where these would cross something
};

/// Every region except the gum is closed by walls. Where two such regions meet along an arc, the wall is a window from
/// the arc down to the straight line between its ends; there is no window if the arc is as low as that line. A cap
/// spans the rest of the border and these lines; below it is the gum. Each wall belongs to both of its regions, so that
/// the solids fill the surface without gap or overlap wherever no wall crosses another wall or the surface.
/// @pre closed and manifold, cut.
PartSolids findWalls(ScanSurface& surface, const WallSettings& settings);

/// The solid of a region. Also sets `is_invented` for its triangles.
TriangleMesh solidOf(const ScanSurface& surface, const PartSolids& solids, std::int32_t region, std::vector<char>& is_invented);

}  // namespace spheretree::builder
