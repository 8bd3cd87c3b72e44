// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of a skin: its contents, its distance from a mesh, and the angles between its facets. docs/measures.md
// Units: mm, rad.
#pragma once

#include <Eigen/Core>

#include "geometry/distance_field.h"
#include "spheretree/builder/evaluation.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/skin.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// The figures that a sound skin itself contains; nothing is measured against a mesh. Cost: 0.3 us a triangle.
SkinEvaluation skinFigures(const Skin& skin);

/// The flat triangles of a skin, in the frame of the mesh: `origin` is that of its tree.
TriangleMesh flatTriangles(const Skin& skin, const Eigen::Vector3d& origin);

/// skinFigures(), and the distances of the flat triangles from `mesh` and of `mesh` from them. `mesh` consists of the
/// solid and everything that belongs to it; `field` is its distance field. The results are proven bounds; they exceed
/// the largest distance by at most 5 % and a quarter of the distance that the skin states. @throws Cancelled.
SkinEvaluation evaluateSkin(const Skin& skin, const Eigen::Vector3d& origin, const TriangleMesh& mesh, const DistanceField& field,
                            Progress& progress);

}  // namespace spheretree::builder
