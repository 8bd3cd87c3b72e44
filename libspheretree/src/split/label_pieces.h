// SPDX-License-Identifier: GPL-3.0-or-later
// Divides the labels of vertices into connected pieces, and removes islands. Units: mm.
#pragma once

#include "split/scan_surface.h"

namespace spheretree::builder {

struct LabelPieces {
  std::vector<std::int32_t> region;        // of each vertex: kGumRegion, or a piece of a label
  std::vector<char> is_island;             // of each vertex: it got another label, since its piece was too small
  std::vector<std::int32_t> region_label;  // of each region; [0] is the gum
  std::vector<int> region_piece;           // 1 for the largest piece of its label
  std::size_t islands = 0;                 // pieces that were too small and were merged into a neighbour
};

/// A piece is a set of vertices of one label that are connected by edges. A piece with an area of less than `min_area`
/// [mm^2] takes the label of the neighbour with the longest common border; one without a neighbour stays. All pieces of
/// gum are one region.
LabelPieces findLabelPieces(const TriangleMesh& mesh, std::vector<std::int32_t> label, double min_area);

}  // namespace spheretree::builder
