// SPDX-License-Identifier: GPL-3.0-or-later
// The skin of an object from its mesh: the surface that a tool is to rest on, with a proof of how far it lies from the
// mesh. docs/algorithms/skin/skin.md
// Units: mm, frame of the mesh; the skin stands in the frame of the tree.
#pragma once

#include <Eigen/Core>
#include <span>

#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/skin.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct SkinSettings {
  double tolerance = 0;  // > 0: that the distance from the mesh and the swing of the patches add up to, at most [mm]
  std::span<const double> tolerance_of_triangle;  // of the solid; empty: the same everywhere. Patches swing out by no more there
  double crease_angle = 0;                        // [rad]; edges that bend more are sharp
};

/// The skin of `solid` and the `sheets` outside it (surface_with_sheets.h), of which `field` knows the distance. The
/// solid must be manifold. Empty if 16 bits cannot name the elements, however the solid is simplified.
/// Deterministic for any number of threads. Cost: 25 ms for 4,000 triangles. @throws Cancelled.
Skin buildSkin(const TriangleMesh& solid, const TriangleMesh& sheets, const DistanceField& field, const Eigen::Vector3d& origin,
               const SkinSettings& settings, Progress& progress);

}  // namespace spheretree::builder
