// SPDX-License-Identifier: GPL-3.0-or-later
// Attaches the centre of each leaf to the surface point nearest to it.
#pragma once

#include <span>
#include <vector>

#include "geometry/distance_field.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/tissue.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {

/// One anchor for each leaf. `field` is that of `mesh`; `bound` is the result of bindSurface() for its vertices.
/// `leaves` are relative to `origin`. At rest an anchor gives the original centre, up to float rounding. Cost: one
/// distance query a leaf.
std::vector<LeafAnchor> anchorLeaves(const TriangleMesh& mesh, const DistanceField& field, std::span<const TissueVertex> bound,
                                     const Tetrahedra& solid, std::span<const Sphere> leaves, const Eigen::Vector3d& origin);

}  // namespace spheretree::builder
