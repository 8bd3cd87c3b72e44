// SPDX-License-Identifier: GPL-3.0-or-later
// How soft tissue moves under small forces on its surface: the inverse of the stiffness matrix of linear elasticity,
// condensed to the nodes of the surface.
// Paper: M. Bro-Nielsen, S. Cotin. Real-time volumetric deformable models for surgery simulation using finite elements
//         and condensation. Computer Graphics Forum 15(3), 1996.
//
// The displacement under a force on one node grows as the elements around it shrink, because the continuum solution is
// singular under a point force. Only the joint displacement of the nodes below a tool is meaningful.
// Units: mm, N.
#pragma once

#include <span>
#include <vector>

#include "spheretree/builder/progress.h"
#include "spheretree/core/skin.h"
#include "spheretree/core/tissue.h"
#include "spheretree/core/triangle_mesh.h"
#include "tissue/elasticity.h"

namespace spheretree::builder {

/// Largest size of the matrix [bytes]; 6 MB are usual for 3,000 tetrahedra.
inline constexpr std::size_t kMaxResponseBytes = 128 << 20;

/// Nodes and matrix of the response; empty if it would be larger than kMaxResponseBytes. `boundary`: from
/// boundaryOf(). Deterministic for any number of threads.
/// Cost: three solves for each free node of the boundary, 24 at a time: about 6 s of one core for 450 nodes.
/// @throws Cancelled.
TissueResponse surfaceResponse(const Elasticity& body, const TriangleMesh& boundary, Progress& progress);

/// For each vertex of `skin` (relative to `origin`), then for the middle of each edge, the nearest point of `boundary`,
/// with which it moves. `pressed`: as in the response.
std::vector<PressPoint> pressPoints(const TriangleMesh& boundary, const Skin& skin, const Eigen::Vector3d& origin,
                                    std::span<const std::uint32_t> pressed);

}  // namespace spheretree::builder
