// SPDX-License-Identifier: GPL-3.0-or-later
// Rounds stored numbers outward, so that a proof in double precision holds for the floats in the file.
#pragma once

#include <cmath>
#include <limits>

namespace spheretree::builder {

/// The smallest float that is not below `x`.
inline float roundUp(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace spheretree::builder
