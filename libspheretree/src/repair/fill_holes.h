// SPDX-License-Identifier: GPL-3.0-or-later
// Closes a surface along its open edges, loop by loop: pinholes, holes, and the open side of a scan.
// Units: mm. Deterministic.
#pragma once

#include <vector>

#include "repair/repair_soup.h"

namespace spheretree::builder {

struct FilledHole {
  std::size_t edges = 0;
  double length = 0;                     // of the border [mm]
  double across = 0;                     // diagonal of the border's box [mm]
  std::vector<std::uint32_t> triangles;  // of the mesh, that fill it
};

/// Adds triangles until no edge is open (findOpenEdges). Every loop of open edges is spanned by the triangulation of
/// least area and bending of its own vertices: P. Liepa. Filling holes in meshes. SGP 2003, as CGAL has it. A loop of
/// more than `most_edges`, or one that has none, is spanned from its middle, which adds a vertex. The filling may cross
/// the surface: resolve_overlaps.h. Longest border first.
std::vector<FilledHole> fillHoles(RepairSoup& soup, std::size_t most_edges = 1500);

}  // namespace spheretree::builder
