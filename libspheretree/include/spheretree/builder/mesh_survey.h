// SPDX-License-Identifier: GPL-3.0-or-later
// What is worth knowing of a mesh beyond its defects (mesh_checks.h): the shape of its borders, cracks and T-junctions
// along them, triangles to turn, parts too small to mean anything, a unit that is unlikely, and how thick and how
// costly to cover the solid is. None of it makes a build refuse. What each figure means: docs/mesh_input.md Units: mm.
// Deterministic: same mesh, same survey, for any number of threads.
#pragma once

#include <string>
#include <vector>

#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Border edges that hang together: one hole, if they are a loop.
struct BorderShape {
  std::size_t edges = 0;
  double length = 0;                    // of its edges [mm]
  bool is_loop = false;                 // one closed line that never meets itself
  double off_plane = 0;                 // of a loop: largest distance of a vertex from its mean plane [mm]
  double roundness = 0;                 // of a loop: 4 pi area / length^2 of its shadow on that plane; 1 for a circle, 0.785 for a square
  Eigen::Vector3d centre;               // mean of its vertices [mm]
  std::vector<std::uint32_t> vertices;  // of a loop: as the triangles run along it; else by index
};

/// A place where the surface comes apart by less than the eye sees.
struct Seam {
  std::uint32_t vertex;  // on a border
  std::uint32_t other;   // crack: the border vertex that it should be; T-junction: the triangle on whose side it lies
  double gap;            // [mm]
  Eigen::Vector3d point;
};

/// Diameters of the largest inner balls that touch the surface, over its area.
struct Thickness {
  double least = 0, fifth_percentile = 0, median = 0, most = 0;  // [mm]
};

/// How many leaves cover the solid with this overhang, by the formula h_fin of docs/measures.md. Builds at standard
/// quality took 0.7 to 1.2 times as many on the meshes it was held against.
struct LeafEstimate {
  double overhang = 0;  // [mm]
  std::size_t leaves = 0;
};

struct MeshSurvey {
  std::vector<BorderShape> borders;       // longest first
  std::vector<Seam> cracks, t_junctions;  // by vertex
  std::vector<std::uint32_t> turned;  // triangles wound against most of their component; empty if none, or if a component cannot be wound
  std::vector<std::uint32_t> one_sided;  // components that have no two sides, as a Moebius strip
  std::vector<std::uint32_t> tiny;       // components with a diagonal below 1 % of the mesh's
  std::string unit_hint;                 // a sentence; empty if the size is that of something on or in a table
  bool has_inside = false;               // what follows was measured: it takes a mesh that a build would take
  Thickness thickness;
  std::vector<LeafEstimate> leaf_estimates;  // for 1, 0.5, 0.2, 0.1 ... per cent of the diagonal
};

/// `report`: of this mesh, from checkMesh. Seams are searched up to 1e-4 of the diagonal. Cost: O(n log n), and 4,000
/// inner balls.
/// @throws Cancelled.
MeshSurvey surveyMesh(const TriangleMesh& mesh, const MeshReport& report, Progress& progress);

/// One line for each finding; empty if there is none. Thickness and leaves are not in it.
std::string summaryOf(const MeshSurvey& survey, const MeshReport& report);

/// A sentence about a diagonal [mm] that is unlikely for something on or in a table, with the `--unit` that would make
/// it likely; else empty.
std::string unitHint(double diagonal);

}  // namespace spheretree::builder
