// SPDX-License-Identifier: GPL-3.0-or-later
// What a burr has left of an object, as a closed mesh. docs/algorithms/cut/remaining_mesh.md
// Units: mm, frame of the object. Deterministic for any number of threads.
#pragma once

#include <span>

#include "cut/swept_burr.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct RemainingMesh {
  TriangleMesh mesh;  // sound (mesh_checks.h); without triangles if nothing is left
  double bound = 0;   // it lies between what burrs leave whose radii are smaller and larger by this [mm]; at most the tolerance
};

/// Surface that the burr did not touch keeps its triangles. `tolerance` [mm]: > 0.
/// @pre `object` is sound. @throws BuildError if a cut with this tolerance fails; Cancelled
RemainingMesh remainingMesh(const TriangleMesh& object, std::span<const BurrPath> paths, double tolerance, Progress& progress);

}  // namespace spheretree::builder
