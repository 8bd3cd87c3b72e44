// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a skin: what it holds, how far it lies from a mesh, and how much its facets bend. docs/measures.md
// Units: mm, rad.
#pragma once

#include <Eigen/Core>

#include "geometry/distance_field.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/skin.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// What a sound skin says of itself; nothing is measured against a mesh. Cost: 0.3 us a triangle.
SkinEvaluation skinFigures(const Skin& skin);

/// The flat triangles of a skin, in the frame of the mesh: `origin` is that of its tree.
TriangleMesh flatTriangles(const Skin& skin, const Eigen::Vector3d& origin);

/// skinFigures(), and how far the flat triangles lie from `mesh` (the solid, and all that belongs to it), whose
/// distances `field` knows, and the mesh from them: proven, at most 5 % and a quarter of what the skin states above the
/// largest distance. @throws Cancelled.
SkinEvaluation evaluateSkin(const Skin& skin, const Eigen::Vector3d& origin, const TriangleMesh& mesh, const DistanceField& field,
                            Progress& progress);

}  // namespace spheretree::builder
