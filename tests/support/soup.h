// SPDX-License-Identifier: GPL-3.0-or-later
// A mesh in the form that repair steps use.
#pragma once

#include <numeric>
#include <random>

#include "repair/repair_soup.h"

namespace spheretree::test {

inline builder::RepairSoup soupOf(const TriangleMesh& mesh) {
  builder::RepairSoup soup{mesh, std::vector<std::uint32_t>(mesh.triangles.size())};
  std::iota(soup.source.begin(), soup.source.end(), 0u);
  return soup;
}

/// Triangles of about `size` in the box [-1, 1]^3, each with its own vertices.
inline TriangleMesh randomTriangles(std::uint32_t count, double size, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] {
    const double x = unit(random), y = unit(random), z = unit(random);
    return Eigen::Vector3d(x, y, z);
  };
  TriangleMesh mesh;
  for (std::uint32_t t = 0; t < count; ++t) {
    const Eigen::Vector3d at = point();
    for (int k = 0; k < 3; ++k) mesh.positions.push_back(at + size * point());
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  return mesh;
}

}  // namespace spheretree::test
