// SPDX-License-Identifier: GPL-3.0-or-later
// How well a sphere-tree approximates a mesh, level by level: the figures that `spheretree evaluate` prints.
// Definitions, methods and accuracy of each figure: docs/measures.md
// Units: mm, frame of the mesh.
#pragma once

#include <cstddef>
#include <cstdint>

#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct EvaluateSettings {
  bool limits = true;        // compute h_fin and h_low for the deepest level
  bool lower_bound = false;  // prove a lower bound of the overhang for the deepest level
  double effort = 1;         // share of the samples and of the work for proofs: less is faster and less exact; range (0, 1]
  std::uint64_t seed = 1;    // of the surface points
  int threads = 0;           // 0: all processors of the machine; the result does not depend on it
};

/// Measures the cover spheres of every level against the mesh. The mesh must be closed, oriented outward and free of
/// self-intersections (mesh_checks.h); otherwise inside and outside are uncertain. The tree must be sound (core's
/// findFault).
/// `cover_too` (repair_mesh.h's `to_cover`; may be empty) is further surface that the tree has to cover: its area
/// counts in the coverage of every level, and overhang is measured from it where it lies outside the solid.
/// Same arguments (except `threads`), same result. Cost: 1 to 2 s on one core for 4,000 triangles and 585 nodes.
/// @throws Cancelled, std::invalid_argument for an empty tree or a mesh without area.
Evaluation evaluateTree(const TriangleMesh& mesh, const SphereTree& tree, const EvaluateSettings& settings, Progress& progress,
                        const TriangleMesh& cover_too = {});

/// Proven: fewer balls than this do not cover `mesh` and `cover_too` if no point of them is farther outside than
/// `overhang` [mm, > 0]. The bound is best for about `spheres` balls, and takes the longer the more: a minute for 512.
/// Theorem: docs/algorithms/measure/lower_bound.md
/// @throws Cancelled, std::invalid_argument for no spheres or a mesh without area.
std::size_t leastSpheres(const TriangleMesh& mesh, double overhang, std::size_t spheres, std::uint64_t seed, Progress& progress,
                         const TriangleMesh& cover_too = {});

}  // namespace spheretree::builder
