// SPDX-License-Identifier: Apache-2.0
// Rounds stored numbers outward, so that a proof in double precision holds for the floats in the file.
#pragma once

#include <cmath>
#include <limits>

namespace spheretree {

/// The smallest float that is not below `x`; infinite if `x` is above all floats.
inline float roundUp(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace spheretree
