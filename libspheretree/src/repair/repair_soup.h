// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of a mesh under repair, and the steps that need only their edges: flat and repeated triangles, cracks,
// winding, dangling sheets. The whole pipeline: repair_mesh.h
// Units: mm. Deterministic.
#pragma once

#include <cstdint>
#include <vector>

#include "repair/repair_work.h"
#include "spheretree/core/none.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct RepairSoup {
  TriangleMesh mesh;                  // without parts
  std::vector<std::uint32_t> source;  // for each triangle: the triangle of the input of which it is (a piece); kNone: of none
};

/// A directed edge that more triangles traverse forwards than backwards. The triangles bound a volume everywhere if and
/// only if there is no such edge: holes, cracks, fins and clashing windings all appear as open edges.
struct OpenEdge {
  std::uint32_t from, to;  // in the direction of the triangles
  std::uint32_t triangle;  // the first one that traverses it in this direction
  int times;               // number of triangles forwards minus backwards, > 0
};
std::vector<OpenEdge> findOpenEdges(const TriangleMesh& mesh);  // by from, then to

/// Removes triangles whose corners are repeated or exactly in line. Returns their sources.
std::vector<std::uint32_t> dropFlat(RepairSoup& soup);

/// Keeps the first of several triangles with the same corners, whatever their winding. Returns the sources of the
/// others.
std::vector<std::uint32_t> dropDuplicates(RepairSoup& soup);

/// Whether two triangles have the same corners, in any order.
bool hasDuplicates(const TriangleMesh& mesh);

struct Stitched {
  double tolerance = 0;           // tolerance that was used [mm]
  std::size_t welded = 0;         // vertices merged into others
  std::size_t split = 0;          // edges that were split at a vertex of a neighbour
  double moved = 0;               // largest motion of a vertex or of a side of a triangle [mm]
  std::vector<char> is_modified;  // for each triangle of the input: whether it moved or vanished
};

/// Merges vertices on open edges that lie within a tolerance of each other, and inserts vertices on open edges into the
/// open edges that they lie on (T-junctions). Tries a sequence of tolerances up to 1e-4 of the diagonal, and takes the
/// smallest one that closes nearly as many edges as the best one. A vertex moves by at most a quarter of its shortest
/// side.
/// @pre no flat triangles. The result may contain flat triangles and duplicates, and at most `max_triangles`: then it
/// leaves T-junctions. @throws TooMuchWork
Stitched stitchCracks(RepairSoup& soup, std::size_t input_triangles, std::size_t max_triangles, RepairWork& work);

/// Turns triangles so that two triangles at an edge traverse it in opposite directions; the larger area keeps its
/// winding. Returns the number of turned triangles. On a surface that cannot be oriented (Moebius strip), some edges
/// remain open.
std::size_t alignWinding(RepairSoup& soup);

/// Whether two triangles still traverse their common edge in the same direction: after alignWinding(), this means a
/// surface that cannot be oriented.
bool isOneSided(const TriangleMesh& mesh);

/// Removes pairs of triangles with the same corners and opposite winding. Rounding makes such pairs of a gap or a wall
/// that is thinner than the rounding error. No edge becomes open by that. Returns their sources.
std::vector<std::uint32_t> cancelOpposites(RepairSoup& soup);

/// Turns the components with negative volume, except those whose box lies within the box of another component: they may
/// be cavities. Returns how many. @pre no open edges. `component_of`: for each triangle, as in MeshReport.
/// @throws TooMuchWork
std::size_t turnInward(RepairSoup& soup, const std::vector<std::uint32_t>& component_of, RepairWork& work);

/// Removes small sheets that are attached to the rest by an edge of three or more triangles and end in a free border.
/// Small means: their box is up to a tenth of the diagonal, and together they have at most 3 % of the area. Returns
/// their sources. @throws TooMuchWork
std::vector<std::uint32_t> dropFins(RepairSoup& soup, RepairWork& work);

}  // namespace spheretree::builder
