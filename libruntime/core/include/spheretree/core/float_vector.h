// SPDX-License-Identifier: Apache-2.0
// Sums over three floats in one order on every machine. Eigen's order depends on the processor: where it has vectors of
// two floats, as 64-bit ARM, the first two terms are added first, elsewhere the last two.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace spheretree {

inline float dotOf(const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a.x() * b.x() + (a.y() * b.y() + a.z() * b.z()); }

inline float squareOf(const Eigen::Vector3f& v) { return dotOf(v, v); }

inline float lengthOf(const Eigen::Vector3f& v) { return std::sqrt(squareOf(v)); }

}  // namespace spheretree
