// SPDX-License-Identifier: GPL-3.0-or-later
// Where triangles cross, cuts them along each other, and keeps what bounds the solid: the points that the surface winds
// round at least once. Overlapping bodies become one, folds and inner walls go.
//
// Paper: Q. Zhou, E. Grinspun, D. Zorin, A. Jacobson. Mesh arrangements for solid geometry. ACM TOG 35(4), 2016. The
//         cuts are exact
// (CGAL), the new corners rounded to double at the end; winding numbers by solid angles (winding_number.h).
// Units: mm. Deterministic.
#pragma once

#include <vector>

#include "repair/repair_soup.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

struct Resolved {
  std::size_t crossing_pairs = 0;
  bool is_stopped = false;                   // more pairs cross than `most_pairs`: the soup is as it was
  bool is_either_way = false;                // solid is what the surface winds round in either direction
  double lost_area = 0;                      // of pieces of the input with nothing solid on either side [mm^2]
  std::vector<std::uint32_t> within;         // sources of which nothing is left, as it lies within solid matter; sorted
  std::vector<std::uint32_t> partly_within;  // ... of which a part is left; sorted
  std::vector<std::uint32_t> lost;           // sources with a piece that has nothing solid on either side; sorted
};

/// The soup must have no open edges (fill_holes.h) for the solid to be beyond doubt; else the winding number is
/// rounded. The result may touch itself in vertices and edges (separate_fans.h), and rounding may leave crossings: try
/// again.
/// `most_lost` [mm^2]: if more of the input than this would have nothing solid on either side, what the surface winds
/// round backwards counts as solid, too: a scan whose cap crosses it encloses matter on both sides of the cap.
/// Cost: about 0.2 ms a crossing pair.
Resolved resolveOverlaps(RepairSoup& soup, std::size_t most_pairs, double most_lost, Progress& progress);

}  // namespace spheretree::builder
