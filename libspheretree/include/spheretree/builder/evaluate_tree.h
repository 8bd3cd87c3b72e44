// SPDX-License-Identifier: GPL-3.0-or-later
// How well a sphere-tree stands for a mesh, level by level: what `spheretree evaluate` prints. Definitions, and how
// each figure is found and how exact it is: docs/measures.md
// Units: mm, frame of the mesh.
#pragma once

#include <cstdint>

#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct EvaluateSettings {
  bool limits = true;      // find h_fin and h_low for the deepest level
  double effort = 1;       // share of the samples and of the length of the proofs: time against exactness; range (0, 1]
  std::uint64_t seed = 1;  // of the surface points
  int threads = 0;         // 0: as many as the machine has; the result does not depend on it
};

/// Measures the cover spheres of every level against the mesh, which must be closed, oriented outward and free of
/// self-intersections (mesh_checks.h), else inside and outside are uncertain. The tree must be sound (core's
/// findFault).
/// `cover_too` (repair_mesh.h's `to_cover`; may be empty) is surface that the tree has to cover as well: it counts in
/// the coverage of every level, by its area, and overhang is measured from it where it lies outside the solid.
/// Same arguments (threads aside), same result. Cost: 1 to 2 s on one core for 4,000 triangles and 585 nodes.
/// @throws Cancelled, std::invalid_argument for an empty tree or a mesh without area.
Evaluation evaluateTree(const TriangleMesh& mesh, const SphereTree& tree, const EvaluateSettings& settings, Progress& progress,
                        const TriangleMesh& cover_too = {});

}  // namespace spheretree::builder
