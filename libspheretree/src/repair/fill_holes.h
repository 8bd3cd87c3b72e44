// SPDX-License-Identifier: GPL-3.0-or-later
// Closes a surface along its open edges, loop by loop: pinholes, holes, and the open side of a scan.
// Units: mm. Deterministic.
#pragma once

#include <vector>

#include "repair/repair_soup.h"
#include "repair/repair_work.h"

namespace spheretree::builder {

/// Simple loops of open edges, each in the direction in which the filling triangles traverse it, opposite to the
/// existing triangles.
std::vector<std::vector<std::uint32_t>> findHoleLoops(const TriangleMesh& mesh);

/// The triangulation of a loop, without further vertices, with the smallest bending and area, wound as the loop runs.
/// Empty if there is none. P. Liepa, as below. Cost: about O(n^1.5) for `n` vertices; O(n^3) if the loop is degenerate,
/// for which a loop of more than kMaxCubicLoop has none. @throws TooMuchWork
std::vector<Triangle> spanLoop(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop, RepairWork& work);
std::vector<Triangle> spanLoop(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop, const Progress& progress = {});

/// Inserts vertices into a span and flips its edges, until its triangles are about as large as the border's edges
/// divided by `density`. The border does not change; a span that is not a manifold surface is left unchanged. P. Liepa,
/// section 4, as implemented in CGAL.
void refineSpan(TriangleMesh& mesh, std::vector<Triangle>& span, double density);

struct FilledHole {
  std::size_t edges = 0;
  double length = 0;                     // of the border [mm]
  double across = 0;                     // diagonal of the border's box [mm]
  std::vector<std::uint32_t> triangles;  // triangles of the mesh that fill it
};

/// Adds triangles until no edge is open (findOpenEdges). Every loop of open edges is filled by the triangulation of its
/// own vertices with the smallest area and bending: P. Liepa. Filling holes in meshes. SGP 2003, as implemented in
/// CGAL. A loop of more than `max_edges`, or one without such a triangulation, is filled by a fan around its centre,
/// which adds a vertex. The filling may cross the surface: resolve_overlaps.h. Longest border first.
/// Adds at most as many triangles as edges are open. @throws TooMuchWork
std::vector<FilledHole> fillHoles(RepairSoup& soup, RepairWork& work, std::size_t max_edges = 1500);

}  // namespace spheretree::builder
