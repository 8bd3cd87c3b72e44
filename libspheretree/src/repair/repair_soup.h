// SPDX-License-Identifier: GPL-3.0-or-later
// The triangles of a mesh under repair, and the steps that need nothing but their edges: flat and repeated triangles,
// cracks, winding, dangling sheets. The whole pipeline: repair_mesh.h
// Units: mm. Deterministic.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

inline constexpr std::uint32_t kAddedTriangle = std::numeric_limits<std::uint32_t>::max();  // of no triangle of the input

struct RepairSoup {
  TriangleMesh mesh;                  // parts are forgotten
  std::vector<std::uint32_t> source;  // for each triangle, that of the input that it is or is a piece of; or kAddedTriangle
};

/// A directed edge that more triangles run along forwards than backwards. The triangles enclose something on every side
/// of theirs iff there is none: holes, cracks, fins and clashing windings all show as open edges.
struct OpenEdge {
  std::uint32_t from, to;  // as the triangles run
  std::uint32_t triangle;  // the first that runs so
  int times;               // forwards less backwards, > 0
};
std::vector<OpenEdge> findOpenEdges(const TriangleMesh& mesh);  // by from, then to

/// Removes triangles with corners that are repeated or exactly in line. Returns their sources.
std::vector<std::uint32_t> dropFlat(RepairSoup& soup);

/// Of triangles with the same corners, whatever their winding, keeps the first. Returns the sources of the others.
std::vector<std::uint32_t> dropDuplicates(RepairSoup& soup);

struct Stitched {
  double tolerance = 0;           // that was needed [mm]
  std::size_t welded = 0;         // vertices that went into others
  std::size_t split = 0;          // edges that got a vertex of a neighbour
  double moved = 0;               // most that a vertex, or a side of a triangle, moved [mm]
  std::vector<char> is_modified;  // for each triangle of the input: whether it moved or vanished
};

/// Joins vertices on open edges that lie within a tolerance of each other, and puts vertices on open edges into the
/// open edges that they lie on (T-junctions). Of a ladder of tolerances up to 1e-4 of the diagonal takes the smallest
/// that closes nearly all that any of them does. A vertex moves by no more than a quarter of its shortest side.
/// @pre no flat triangles. May leave some; and duplicates.
Stitched stitchCracks(RepairSoup& soup, std::size_t input_triangles);

/// Turns triangles so that neighbours across edges of two triangles run along them in opposite directions; the larger
/// area keeps its winding. Returns how many triangles it turned. Where a sheet has but one side (Moebius), some edges
/// stay open.
std::size_t alignWinding(RepairSoup& soup);

/// Whether an edge of two triangles is left along which they run in the same direction: after alignWinding, a sheet of
/// one side only.
bool isOneSided(const TriangleMesh& mesh);

/// Removes triangles with the same corners and opposite winding, two by two: what rounding makes of a gap or a wall
/// thinner than itself. No edge becomes open by that. Returns their sources.
std::vector<std::uint32_t> cancelOpposites(RepairSoup& soup);

/// Turns the components whose volume is negative, but for those whose box lies within the box of another: they may be
/// cavities. Returns how many. @pre no open edges. `component_of`: for each triangle, as in MeshReport.
std::size_t turnInward(RepairSoup& soup, const std::vector<std::uint32_t>& component_of);

/// Removes sheets that hang on the rest by an edge of three or more triangles and end in a free border, as long as they
/// are small: their box up to a tenth of the diagonal, together at most 3 % of the area. Returns their sources.
std::vector<std::uint32_t> dropFins(RepairSoup& soup);

}  // namespace spheretree::builder
