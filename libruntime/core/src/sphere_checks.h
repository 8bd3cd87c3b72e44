// SPDX-License-Identifier: Apache-2.0
// The check of spheres that the writer and the reader share: one expression for both. Each of its operations is
// correctly rounded on every processor and by every compiler, so that both get the same result.
#pragma once

#include <cmath>

#include "spheretree/core/sphere.h"

namespace spheretree {

inline bool isFinite(const Sphere& s) {
  return std::isfinite(s.x) && std::isfinite(s.y) && std::isfinite(s.z) && std::isfinite(s.radius) && s.radius > 0;
}

/// The radius about the centre of `from` that encloses all of `to`.
inline double reach(const Sphere& from, const Sphere& to) {
  const double dx = static_cast<double>(to.x) - static_cast<double>(from.x), dy = static_cast<double>(to.y) - static_cast<double>(from.y),
               dz = static_cast<double>(to.z) - static_cast<double>(from.z);
  return std::sqrt(dx * dx + dy * dy + dz * dz) + static_cast<double>(to.radius);
}

}  // namespace spheretree
