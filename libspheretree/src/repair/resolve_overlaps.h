// SPDX-License-Identifier: GPL-3.0-or-later
// Where triangles cross, cuts them along each other and keeps the boundary of the solid, that is of the points with a
// winding number of at least 1. Overlapping bodies become one body; folds and inner walls disappear.
//
// Paper: Q. Zhou, E. Grinspun, D. Zorin, A. Jacobson. Mesh arrangements for solid geometry. ACM TOG 35(4), 2016. The
// arrangement: arrange_triangles.h; winding numbers by solid angles: winding_number.h
// Units: mm. Deterministic.
#pragma once

#include <vector>

#include "repair/repair_soup.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct Resolved {
  std::size_t crossing_pairs = 0;
  bool is_stopped = false;                   // a limit would be exceeded: nothing was cut
  bool is_either_way = false;                // points with a winding number of at most -1 also count as solid
  double lost_area = 0;                      // area of pieces of the input with nothing solid on either side [mm^2]
  std::vector<std::uint32_t> within;         // sources of which nothing remains, because they lie within solid matter; sorted
  std::vector<std::uint32_t> partly_within;  // sources of which a part remains; sorted
  std::vector<std::uint32_t> lost;           // sources with a piece that has nothing solid on either side; sorted
  double snapped = 0;                        // largest motion of a vertex onto the grid [mm]
  std::vector<std::uint32_t> moved;          // sources that it moved; sorted
};

struct OverlapLimits {
  std::size_t pairs;   // of triangles that cross
  std::size_t pieces;  // into which all triangles are cut
};

/// The soup should have no open edges (fill_holes.h), so that the solid is unambiguous; otherwise the winding number is
/// rounded. The result may touch itself in vertices and edges (separate_fans.h), and rounding may leave crossings: then
/// call it again.
/// `grid` [mm]: if above 0, the vertices of triangles that cross are moved to multiples of it and merged before the
/// cut; a power of two, so that they are exact. A cut rounds new corners, and where surfaces nearly coincide, the
/// rounded pieces cross again, more of them each time. D. Halperin, E. Packer. Iterated snap rounding. Computational
/// Geometry 23(2), 2002, does so in the plane; CGAL's autorefinement (from 6.1 on) in space.
/// `max_lost` [mm^2]: if more area than this would have nothing solid on either side, negative winding numbers count
/// as solid, too. Such is a scan that its own cap crosses: it encloses matter on both sides of the cap.
/// Cost: about 0.1 ms a crossing pair. @throws Cancelled, TooMuchWork
Resolved resolveOverlaps(RepairSoup& soup, const OverlapLimits& limits, double grid, double max_lost, Progress& progress, RepairWork& work);

}  // namespace spheretree::builder
