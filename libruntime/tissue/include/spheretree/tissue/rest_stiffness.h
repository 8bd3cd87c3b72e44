// SPDX-License-Identifier: Apache-2.0
// The stiffness of tissue at rest: the second derivative of the energy of tissue_solver.h where nothing has moved,
// which is linear elasticity on the same elements. With H the mean of the gradient of the displacements, round an edge
// and round a node, the energy of small motion is
//     sum over edges  V mu |(H + H^T) / 2|^2  +  sum over nodes  V lambda / 2 (tr H)^2.
// Units: mm, N.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <array>
#include <cstdint>
#include <span>

#include "spheretree/core/tissue.h"

namespace spheretree::tissue {

/// Of all nodes, three rows and columns each: symmetric, both halves [N/mm]. `corners` as in Tissue::tetrahedra:
/// indices in range, volumes positive. Deterministic. Cost: about 0.2 ms a tetrahedron. @throws std::bad_alloc.
Eigen::SparseMatrix<double> restStiffness(std::span<const Eigen::Vector3d> nodes, std::span<const std::array<std::uint32_t, 4>> corners,
                                          const TissueMaterial& material);

}  // namespace spheretree::tissue
