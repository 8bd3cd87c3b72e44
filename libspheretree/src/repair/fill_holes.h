// SPDX-License-Identifier: GPL-3.0-or-later
// Closes a surface along its open edges, loop by loop: pinholes, holes, and the open side of a scan.
// Units: mm. Deterministic.
#pragma once

#include <vector>

#include "repair/repair_soup.h"

namespace spheretree::builder {

/// Simple loops of open edges, each against the direction of the triangles: as the triangles that fill it run.
std::vector<std::vector<std::uint32_t>> findHoleLoops(const TriangleMesh& mesh);

/// The triangulation of least bending and area of a loop without further vertices, wound as the loop runs; empty if
/// there is none. P. Liepa, as below. Cost: about O(n^1.5) for `n` vertices, O(n^3) where the loop is degenerate.
std::vector<Triangle> spanLoop(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop);

/// Puts vertices into a span and flips its edges, so that triangles are about as large as the border's edges divided by
/// `density`. The border stays; a span that is no manifold surface stays as it is. P. Liepa, section 4, as CGAL has it.
void refineSpan(TriangleMesh& mesh, std::vector<Triangle>& span, double density);

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
