// SPDX-License-Identifier: GPL-3.0-or-later
// Makes a closed, manifold surface, wound outward, that does not cross itself, of nearly any triangles: what the
// builders need. As little as possible is done, step by step; every step that does anything is named, with what it
// changed and how far at most. The steps and what each guarantees: docs/mesh_input.md
// Units: mm. Deterministic: same mesh, same result.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

enum class RepairKind {
  Auto,  // the least that works
  Off,   // nothing: a mesh with defects stays as it is; components within solid matter are left out all the same
  Wrap   // an alpha wrap, whatever the mesh
};

enum class RepairStepKind {
  DropFlat,         // triangles of zero area
  DropDuplicates,   // triangles with the corners of an earlier one
  StitchCracks,     // vertices on cracks joined, T-junctions closed
  DropFins,         // small sheets that hang on an edge of the rest
  AlignWinding,     // triangles turned to agree with their neighbours
  FillHoles,        // borders closed that are short of a quarter of the diagonal
  CapOpenings,      // the longer ones: the open side of a scan
  TurnOutward,      // components that were inside out
  ResolveOverlaps,  // triangles that cross cut; what lies within solid matter removed
  SeparateBodies,   // bodies that touch in a vertex or along an edge are drawn apart by little
  DropBuried,       // components wholly within solid matter
  Wrap              // the surface replaced by an alpha wrap
};

/// "stitch cracks"; in reports with '_' in place of blanks.
std::string_view name(RepairStepKind kind);

struct RepairStep {
  RepairStepKind kind;
  std::string text;       // one sentence for people: what, how many, how far
  std::size_t count = 0;  // of what the step is about: triangles, vertices, holes, components, pairs
  double change_mm = 0;   // no point of what it moved, added or removed lies farther than this from the surface before (removed:
                          // after) it; 0 where the surface stayed or nothing but matter within the solid went
  std::vector<std::uint32_t> removed;  // triangles of the input that are no part of the solid's surface afterwards and need not be
                                       // covered: left out, or deep within the solid; sorted
};

struct RepairedMesh {
  TriangleMesh mesh;      // sound if isSound(); parts are kept if nothing but turned or left out components changed
  TriangleMesh to_cover;  // triangles of the input, or pieces, that are not part of `mesh` exactly and have to be covered too
  // Triangles of the input that need no cover where they lie deep within the solid; sorted. `mesh` and `to_cover` hold
  // all of the input but for that and for what the steps removed.
  std::vector<std::uint32_t> partly;
  std::vector<RepairStep> steps;
  double bound_mm = 0;  // no point of the surface of `mesh` lies farther from the input's triangles, holes that were filled aside
  MeshReport report;    // of the input
  MeshReport result;    // of `mesh`

  bool isSound() const { return result.clean(); }
};

/// Never throws for a defect: a mesh that cannot be repaired (no triangles, bad numbers, an absurd size, zero area)
/// comes back as it is, with a `result` that is not clean.
/// Cost: that of checkMesh for a sound mesh; some seconds for 100,000 triangles with defects; a wrap 2 to 30 s.
/// @throws Cancelled
RepairedMesh repairMesh(const TriangleMesh& mesh, RepairKind kind, Progress& progress);

}  // namespace spheretree::builder
