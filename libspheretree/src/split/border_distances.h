// SPDX-License-Identifier: GPL-3.0-or-later
// Distances of the vertices of a surface to the borders of its regions. Units: mm.
#pragma once

#include "split/scan_surface.h"

namespace spheretree::builder {

inline constexpr int kSmoothingRounds = 4;  // of the borders; each moves them by an edge or by `smooth` at most

struct RegionDistance {
  std::int32_t region;
  double distance;  // to the border of the region [mm]; positive within it
};

struct BorderDistances {
  double band = 0;                                     // distances beyond this one are not listed [mm]
  std::vector<std::vector<RegionDistance>> of_vertex;  // by region; a vertex has only a few
};

/// The border of a region runs through the middles of the edges between vertices within and outside it. Distances are
/// exact within the triangles that it crosses, and measured along edges beyond them. The band is wide enough for a
/// border that then moves by `smooth` [mm].
///
/// Jagged labels are random in a ring of vertices on both sides of the true border, and a run of equal ones looks like
/// a smooth border. So the border of a region with jagged labels is put into the middle between the vertices that are
/// certain to be within the region and those that are certain not to be, because all of their neighbours agree; it
/// moves by at most one edge. The border of the gum moves with that of the nearest tooth.
BorderDistances findBorderDistances(const ScanSurface& surface, const VertexNeighbours& neighbours, double smooth);

}  // namespace spheretree::builder
