// SPDX-License-Identifier: GPL-3.0-or-later
// The last step of a build: proves what a tree promises about its mesh, from the tree as a reader of its file gets it.
// How: docs/algorithms/certify/certify_cover.md
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "geometry/distance_field.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// Whether the spheres, whose centres are relative to `origin`, cover every triangle of the mesh. Exact, by power
/// cells; where rounding leaves a doubt, false. Deterministic for any number of threads. Cost: as certifyCover().
bool provenCovered(const TriangleMesh& mesh, std::span<const Sphere> spheres, const Eigen::Vector3d& origin, Progress& progress);

/// Returns which promise of a decoded tree does not hold for `mesh`, or an empty text: the spheres of each level cover
/// it, and none reaches out of `field` by more than the bound of its level. decodeSphereTree() has already checked that
/// the bounding spheres enclose what lies below them.
std::string findUnproven(const TriangleMesh& mesh, const DistanceField& field, const SphereTree& decoded, Progress& progress);

}  // namespace spheretree::builder
