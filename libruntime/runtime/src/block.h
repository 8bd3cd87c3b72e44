// SPDX-License-Identifier: Apache-2.0
// Filling the blocks of 8 spheres that the search tests.
#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

inline constexpr float kFarAway = 1e18f;  // an empty lane; its squared distance still fits a float

inline Block emptyBlock() {
  Block empty;
  std::fill_n(empty.x, 8, kFarAway);
  std::fill_n(empty.y, 8, kFarAway);
  std::fill_n(empty.z, 8, kFarAway);
  std::fill_n(empty.r, 8, 0.0f);
  return empty;
}

inline void put(Block& block, std::size_t lane, const Eigen::Vector3d& c, float radius) {
  block.x[lane] = static_cast<float>(c.x());
  block.y[lane] = static_cast<float>(c.y());
  block.z[lane] = static_cast<float>(c.z());
  block.r[lane] = radius;
}

}  // namespace spheretree::runtime
