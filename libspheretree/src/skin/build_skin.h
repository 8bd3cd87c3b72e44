// SPDX-License-Identifier: GPL-3.0-or-later
// Makes the skin of an object from its mesh: the surface that a tool rests on, with a proof of its distance from the
// mesh. docs/algorithms/skin/skin.md
// Units: mm, frame of the mesh; the skin itself is in the frame of the tree.
#pragma once

#include <Eigen/Core>
#include <span>

#include "base/ball.h"
#include "geometry/distance_field.h"
#include "mesh/simplify_mesh.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/skin.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

struct SkinSettings {
  double tolerance = 0;  // > 0: limit of the sum of the distance from the mesh and the swing of the patches [mm]
  std::span<const double>
      tolerance_of_triangle;  // of the solid's triangles; limits the swing of the patches there; empty: the same everywhere
  double crease_angle = 0;    // [rad]; edges with a larger angle are sharp
};

/// The skin of `solid` and the `sheets` outside it (surface_with_sheets.h); `field` is the distance field of both. The
/// solid must be manifold. Empty if even the simplified solid has more elements than 16 bits can number. Deterministic
/// for any number of threads. `simplifier`: of the solid, to go on from where it is; may be null.
/// `simplified_distance`: proven, no point of the solid is farther than this from the surface of the simplifier [mm].
/// Cost: 25 ms for 4,000 triangles. @throws Cancelled.
Skin buildSkin(const TriangleMesh& solid, const TriangleMesh& sheets, const DistanceField& field, const Eigen::Vector3d& origin,
               const SkinSettings& settings, Progress& progress, MeshSimplifier* simplifier = nullptr,
               double simplified_distance = kInfinity);

}  // namespace spheretree::builder
