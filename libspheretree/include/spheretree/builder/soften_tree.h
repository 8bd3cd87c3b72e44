// SPDX-License-Identifier: GPL-3.0-or-later
// From a sphere-tree, and tetrahedra that fill its mesh, makes a tree that moves with soft tissue. docs/tissue.md
// Units: mm, kPa, kg/m^3.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// `surface`: the mesh that the tree covers, together with the pieces that its repair adds to the cover (core's
/// joined()). `boundary`: the closed surface that `tetrahedra` fill, that is the mesh or a simplified form of it.
/// `is_fixed(position)` tells whether a node stays in place. Same arguments, same bytes.
/// @throws BuildError for tetrahedra that do not fill the boundary, a part without fixed nodes, or a mesh that does not
/// belong to the tree; std::invalid_argument for a material out of range; Cancelled.
Tissue softenTree(const TriangleMesh& surface, const SphereTree& tree, const TriangleMesh& boundary, const TetrahedronList& tetrahedra,
                  const TissueMaterial& material, const std::function<bool(const Eigen::Vector3d&)>& is_fixed, Progress& progress);

}  // namespace spheretree::builder
