// SPDX-License-Identifier: Apache-2.0
// The stiffness of tissue at rest: the second derivative of the energy of tissue_solver.h at zero displacement, which
// is linear elasticity on the same elements. With H the mean of the displacement gradient around an edge or around a
// node, the energy of small deformations is
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

/// The stiffness matrix of all nodes, three rows and columns each: symmetric, both halves stored [N/mm]. `corners` as
/// in Tissue::tetrahedra, with indices in range and positive volumes. Deterministic. Cost: about 0.2 ms a tetrahedron.
/// @throws std::bad_alloc.
Eigen::SparseMatrix<double> restStiffness(std::span<const Eigen::Vector3d> nodes, std::span<const std::array<std::uint32_t, 4>> corners,
                                          const TissueMaterial& material);

}  // namespace spheretree::tissue
