// SPDX-License-Identifier: GPL-3.0-or-later
// Solids in tetrahedra that need no mesher.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "spheretree/core/tissue.h"

namespace spheretree::test {

/// The box from the origin to `size` in cells of six tetrahedra each, around their diagonal (H. Freudenthal 1942), so
/// that the diagonals of neighbours agree.
inline TetrahedronList boxTetrahedra(const Eigen::Vector3d& size, const std::array<std::uint32_t, 3>& cells) {
  TetrahedronList solid;
  const auto at = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) { return (z * (cells[1] + 1) + y) * (cells[0] + 1) + x; };
  for (std::uint32_t z = 0; z <= cells[2]; ++z)
    for (std::uint32_t y = 0; y <= cells[1]; ++y)
      for (std::uint32_t x = 0; x <= cells[0]; ++x)
        solid.nodes.emplace_back(size.x() * x / cells[0], size.y() * y / cells[1], size.z() * z / cells[2]);
  constexpr std::array<std::array<int, 3>, 6> kOrders{{{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}}};
  for (std::uint32_t z = 0; z < cells[2]; ++z)
    for (std::uint32_t y = 0; y < cells[1]; ++y)
      for (std::uint32_t x = 0; x < cells[0]; ++x)
        for (std::size_t k = 0; k < kOrders.size(); ++k) {
          std::array<std::uint32_t, 3> p{x, y, z};
          std::array<std::uint32_t, 4> c{at(x, y, z)};
          for (std::size_t i = 0; i < 3; ++i) ++p[static_cast<std::size_t>(kOrders[k][i])], c[i + 1] = at(p[0], p[1], p[2]);
          if (k >= 3) std::swap(c[2], c[3]);  // odd orders are inside out
          solid.corners.push_back(c);
        }
  return solid;
}

}  // namespace spheretree::test
