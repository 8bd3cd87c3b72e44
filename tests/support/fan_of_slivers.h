// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include "spheretree/core/triangle_mesh.h"

namespace spheretree::test {

/// A flat disc of radius 1 about the origin, vertex 0, with its normal along z. Vertex 1 is at (1, 0, 0).
inline TriangleMesh fanOfSlivers(std::uint32_t count) {
  TriangleMesh fan;
  fan.positions.emplace_back(0, 0, 0);
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    fan.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
    fan.triangles.push_back({0, 1 + i, 1 + (i + 1) % count});
  }
  return fan;
}

}  // namespace spheretree::test
