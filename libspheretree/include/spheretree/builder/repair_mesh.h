// SPDX-License-Identifier: GPL-3.0-or-later
// Makes a closed, manifold surface, wound outward and free of self-intersections, which the builders need, from nearly
// any triangles. It changes as little as possible, step by step, and reports each step that changed something, with the
// largest distance that it changed. The steps and their guarantees: docs/mesh_input.md
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
  Auto,  // the smallest change that works
  Off,   // no repair: a mesh with defects stays as it is, but components within solid matter are still left out
  Wrap   // an alpha wrap, for any mesh
};

enum class RepairStepKind {
  DropFlat,         // triangles of zero area
  DropDuplicates,   // triangles with the corners of an earlier one
  StitchCracks,     // vertices along cracks joined, T-junctions closed
  DropFins,         // small sheets that are attached to the rest by an edge
  AlignWinding,     // triangles turned to agree with their neighbours
  FillHoles,        // closed borders that are shorter than a quarter of the diagonal
  CapOpenings,      // longer borders: the open side of a scan
  TurnOutward,      // components that were inside out
  ResolveOverlaps,  // crossing triangles cut; parts within solid matter removed
  SeparateBodies,   // bodies that touch in a vertex or along an edge, moved apart slightly
  DropBuried,       // components wholly within solid matter
  Wrap              // the surface replaced by an alpha wrap
};

/// For example "stitch cracks"; reports have '_' in place of blanks.
std::string_view name(RepairStepKind kind);

struct RepairStep {
  RepairStepKind kind;
  std::string text;       // one sentence for people: what changed, how many, how far
  std::size_t count = 0;  // how many triangles, vertices, holes, components or pairs the step changed
  double change_mm = 0;   // no point that it moved, added or removed lies farther than this from the surface before the step (removed
                          // points: after it); 0 if the surface did not change or lost only matter within the solid
  std::vector<std::uint32_t> removed;  // triangles of the input that are no longer part of the solid's surface and need not be covered,
                                       // because they were left out or lie deep within the solid; sorted
};

struct RepairedMesh {
  TriangleMesh mesh;      // sound if isSound(); keeps its parts if the repair only turned or removed components
  TriangleMesh to_cover;  // triangles of the input, or pieces of them, that are not exactly part of `mesh` but have to be covered
  // Triangles of the input that need no cover where they lie deep within the solid; sorted. Apart from these places and
  // from what the steps removed, `mesh` and `to_cover` contain the whole input.
  std::vector<std::uint32_t> partly;
  std::vector<RepairStep> steps;
  double bound_mm = 0;  // no point of the surface of `mesh`, except in filled holes, lies farther than this from the input's triangles
  MeshReport report;    // of the input
  MeshReport result;    // of `mesh`

  bool isSound() const { return result.clean(); }
};

/// Never throws for a defect: a mesh that cannot be repaired (no triangles, bad numbers, an absurd size, zero area) is
/// returned unchanged, with a `result` that is not clean.
/// Cost: that of checkMesh for a sound mesh; some seconds for 100,000 triangles with defects; a wrap 2 to 30 s.
/// @throws Cancelled
RepairedMesh repairMesh(const TriangleMesh& mesh, RepairKind kind, Progress& progress);

}  // namespace spheretree::builder
