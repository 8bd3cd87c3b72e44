// SPDX-License-Identifier: GPL-3.0-or-later
// What is left of a solid when another one is taken away. The triangles that do not cross stay as they are.
// Units: mm. Deterministic.
#pragma once

#include <optional>

#include "spheretree/builder/progress.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct Difference {
  TriangleMesh mesh;  // sound (mesh_checks.h); without triangles if nothing is left
  double moved = 0;   // no vertex was moved farther: to draw bodies apart that touch, or for cuts that rounding spoils [mm]
};

/// Empty if rounding leaves crossings after several cuts, or for too many.
/// Method: resolve_overlaps.h, with `taken` turned inside out; it may also cross itself.
/// @pre `from` is sound; `taken` has no open edges. Cost: about 0.1 ms a crossing pair. @throws Cancelled
std::optional<Difference> subtractSolid(const TriangleMesh& from, const TriangleMesh& taken, Progress& progress);

}  // namespace spheretree::builder
