// SPDX-License-Identifier: Apache-2.0
// Rounds numbers to what a file holds. A number that is stored and also calculated with goes through these functions,
// so that a proof in double precision is about the stored number.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>

namespace spheretree {

/// A share of the largest number or length in a calculation that is above the rounding errors of a distance, or of a
/// sum of some dozens of products: these are at most 1e-13 of it.
inline constexpr double kRounding = 1e-12;

/// The float nearest to `x`. The compiler cannot see what the empty statement does to it, and therefore keeps the
/// rounding: GCC 12 drops that of two neighbouring numbers if they are widened again (docs/architecture.md).
inline float roundToFloat(double x) {
#if defined(__GNUC__) && defined(__SSE__)
  auto rounded = static_cast<float>(x);
  asm("" : "+x"(rounded));
#elif defined(__GNUC__)
  auto rounded = static_cast<float>(x);
  asm("" : "+m"(rounded));
#else
  const volatile auto rounded = static_cast<float>(x);
#endif
  return rounded;
}

inline Eigen::Vector3f roundToFloat(const Eigen::Vector3d& x) { return {roundToFloat(x.x()), roundToFloat(x.y()), roundToFloat(x.z())}; }

/// The smallest float that is not below `x`; infinite if `x` is above all floats.
inline float roundUp(double x) {
  const float f = roundToFloat(x);
  return static_cast<double>(f) < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

}  // namespace spheretree
