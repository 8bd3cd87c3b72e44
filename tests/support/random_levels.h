// SPDX-License-Identifier: GPL-3.0-or-later
// Spheres of levels made without a builder, for tests of the stages after it.
#pragma once

#include <cmath>
#include <vector>

#include "spheretree/core/sphere.h"
#include "support/random.h"

namespace spheretree::test {

using Levels = std::vector<std::vector<Sphere>>;

inline Sphere sphere(const Eigen::Vector3d& c, double radius) {
  return {static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()), static_cast<float>(radius)};
}

// Spheres scattered over a flat box; deeper levels have smaller ones.
inline Levels randomLevels(const std::vector<std::size_t>& sizes, std::uint64_t seed) {
  Random random(seed);
  Levels levels;
  for (const std::size_t size : sizes) {
    levels.emplace_back();
    for (std::size_t i = 0; i < size; ++i) {
      const Eigen::Vector3d c = random.inBox({-10, -7, -1}, {10, 7, 1});
      levels.back().push_back(sphere(c, random.between(0.8, 1.2) * 12 / std::sqrt(static_cast<double>(size))));
    }
  }
  return levels;
}

}  // namespace spheretree::test
