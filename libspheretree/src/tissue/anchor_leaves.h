// SPDX-License-Identifier: GPL-3.0-or-later
// Ties the centre of each leaf to the surface point nearest to it.
#pragma once

#include <span>
#include <vector>

#include "geometry/distance_field.h"
#include "spheretree/core/sphere.h"
#include "spheretree/core/tissue.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {

/// One anchor for each leaf. `field`: of `mesh`, whose vertices are `bound` as bindSurface() found them. `leaves` are
/// relative to `origin`. At rest an anchor gives the centre back, but for the rounding of floats.
/// Cost: one distance query a leaf.
std::vector<LeafAnchor> anchorLeaves(const TriangleMesh& mesh, const DistanceField& field, std::span<const TissueVertex> bound,
                                     const Tetrahedra& solid, std::span<const Sphere> leaves, const Eigen::Vector3d& origin);

}  // namespace spheretree::builder
