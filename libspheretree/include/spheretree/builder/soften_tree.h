// SPDX-License-Identifier: GPL-3.0-or-later
// A sphere-tree, and tetrahedra that fill its mesh, to a tree that moves with soft tissue. docs/tissue.md
// Units: mm, kPa, kg/m^3.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// `surface`: what the tree covers, the mesh with the pieces that its repair wants covered too (core's joined()).
/// `boundary`: the closed surface that `tetrahedra` fill, the mesh or a simplified form of it. `is_fixed(position)`
/// says which nodes stay where they are. Same arguments, same bytes.
/// @throws BuildError for tetrahedra that do not fill the boundary, a part that is not held, or a mesh that is not the
/// one of the tree; std::invalid_argument for a material out of range; Cancelled.
Tissue softenTree(const TriangleMesh& surface, const SphereTree& tree, const TriangleMesh& boundary, const TetrahedronList& tetrahedra,
                  const TissueMaterial& material, const std::function<bool(const Eigen::Vector3d&)>& is_fixed, Progress& progress);

}  // namespace spheretree::builder
