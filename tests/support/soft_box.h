// SPDX-License-Identifier: GPL-3.0-or-later
// A box of soft tissue for tests of the solver, without leaves and without a response.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "spheretree/core/tissue.h"
#include "support/random.h"
#include "support/tetrahedra.h"

namespace spheretree::test {

using Field = std::vector<Eigen::Vector3d>;  // (nodes)

/// A box with the nodes fixed that satisfy `is_fixed`; its inner nodes are moved at random by `disorder`.
inline Tissue softBox(const Eigen::Vector3d& size, const std::array<std::uint32_t, 3>& cells, const TissueMaterial& material,
                      const std::function<bool(const Eigen::Vector3d&)>& is_fixed, double disorder = 0) {
  const TetrahedronList solid = boxTetrahedra(size, cells);
  Random random(3);
  Tissue tissue;
  tissue.material = material;
  for (Eigen::Vector3d p : solid.nodes) {
    if (p.minCoeff() > 1e-9 && (size - p).minCoeff() > 1e-9) p += random.inCube(disorder);
    if (is_fixed(p)) tissue.fixed.push_back(static_cast<std::uint32_t>(tissue.nodes.size()));
    tissue.nodes.push_back({p.x(), p.y(), p.z()});
  }
  tissue.tetrahedra = solid.corners;
  tissue.surface.push_back({tissue.nodes[0], 0, {1, 0, 0}});  // tissue must have a surface
  return tissue;
}

inline bool isBelow(const Eigen::Vector3d& p) { return p.z() < 1e-9; }

inline Eigen::Vector3d at(const Tissue& tissue, std::size_t i) { return {tissue.nodes[i][0], tissue.nodes[i][1], tissue.nodes[i][2]}; }
inline Field noForces(const Tissue& tissue) { return Field(tissue.nodes.size(), Eigen::Vector3d::Zero()); }

}  // namespace spheretree::test
