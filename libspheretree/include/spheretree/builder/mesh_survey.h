// SPDX-License-Identifier: GPL-3.0-or-later
// Properties of a mesh beyond its defects (mesh_checks.h): the shape of its borders, cracks and T-junctions along them,
// triangles with the wrong winding, tiny components, an unlikely unit, the thickness of the solid and the number of
// leaves that cover it. No result makes a build refuse the mesh. Definitions: docs/mesh_input.md
// Units: mm. Deterministic: same mesh, same survey, for any number of threads.
#pragma once

#include <string>
#include <vector>

#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/progress.h"

namespace spheretree::builder {

/// Connected border edges: one hole if they form a loop.
struct BorderShape {
  std::size_t edges = 0;
  double length = 0;       // of its edges [mm]
  bool is_loop = false;    // one closed line that never meets itself
  double off_plane = 0;    // of a loop: largest distance of a vertex from its mean plane [mm]
  double roundness = 0;    // of a loop: 4 pi area / length^2 of its projection onto that plane; 1 for a circle, 0.785 for a square
  Eigen::Vector3d centre;  // mean of its vertices [mm]
  std::vector<std::uint32_t> vertices;  // of a loop: in the order in which its triangles traverse it; else by index
};

/// A place where the surface is open by an invisibly small gap.
struct Seam {
  std::uint32_t vertex;  // on a border
  std::uint32_t other;   // crack: the border vertex that should be the same vertex; T-junction: the triangle on whose side the vertex lies
  double gap;            // [mm]
  Eigen::Vector3d point;
};

/// Diameters of the largest inner balls that touch the surface, weighted by area.
struct Thickness {
  double smallest = 0, fifth_percentile = 0, median = 0, largest = 0;  // [mm]
};

/// Number of leaves that cover the solid with this overhang, by the formula h_fin of docs/measures.md. A build may
/// need fewer, as teeth do, or more.
struct LeafEstimate {
  double overhang = 0;  // [mm]
  std::size_t leaves = 0;
};

struct MeshSurvey {
  std::vector<BorderShape> borders;       // longest first
  std::vector<Seam> cracks, t_junctions;  // by vertex
  std::vector<std::uint32_t>
      turned;  // triangles wound against the majority of their component; empty if none, or if a component cannot be wound consistently
  std::vector<std::uint32_t> one_sided;  // components that cannot be oriented, such as a Moebius strip
  std::vector<std::uint32_t> tiny;       // components with a diagonal below 1 % of the mesh's
  std::string unit_hint;                 // a sentence; empty if the size is plausible for an object on a table
  bool has_inside = false;               // true: the members below were measured; this needs a mesh that a build accepts
  Thickness thickness;
  std::vector<LeafEstimate> leaf_estimates;  // for 1, 0.5, 0.2, 0.1 ... per cent of the diagonal
};

/// `report`: from checkMesh of this mesh. `unit_mm`: as for unitHint(). Seams are searched up to 1e-4 of the diagonal.
/// Cost: O(n log n), and 4,000 inner balls.
/// @throws Cancelled.
MeshSurvey surveyMesh(const TriangleMesh& mesh, const MeshReport& report, Progress& progress, double unit_mm = 1);

/// One line for each finding, without thickness and leaves; empty if there is none.
std::string summaryOf(const MeshSurvey& survey, const MeshReport& report);

/// If the diagonal [mm] is implausible for an object on a table: a sentence that says so, with every `--unit` that
/// would make it plausible. Otherwise empty. `unit_mm`: the length of the unit in which the file was read.
std::string unitHint(double diagonal, double unit_mm = 1);

}  // namespace spheretree::builder
