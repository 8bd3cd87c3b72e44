// SPDX-License-Identifier: Apache-2.0
// Sums over three floats in one order on every machine. Eigen's order depends on the processor: where it has vectors of
// two floats, as 64-bit ARM, the first two terms are added first, elsewhere the last two.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace spheretree {

inline float dotOf(const Eigen::Vector3f& a, const Eigen::Vector3f& b) { return a.x() * b.x() + (a.y() * b.y() + a.z() * b.z()); }

inline float squareOf(const Eigen::Vector3f& v) { return dotOf(v, v); }

/// Adds a fourth component that is 0: one instruction takes all of a vector. In place, since a processor waits for a
/// vector that it has just written one component at a time.
inline void pad(const Eigen::Vector3f& v, Eigen::Vector4f& out) { out[0] = v[0], out[1] = v[1], out[2] = v[2], out[3] = 0; }

inline float squareOfPadded(const Eigen::Vector4f& v) {
  const Eigen::Vector4f squares = v.cwiseProduct(v);
  return squares.x() + (squares.y() + squares.z());
}

inline float lengthOf(const Eigen::Vector3f& v) { return std::sqrt(squareOf(v)); }

}  // namespace spheretree
