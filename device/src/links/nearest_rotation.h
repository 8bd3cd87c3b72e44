// SPDX-License-Identifier: Apache-2.0
// Rotations that vendors' libraries report as matrices.
#pragma once

#include <optional>

#include "spheretree/core/rigid.h"

namespace spheretree::device {

/// The nearest rotation, by Newton's iteration for the polar factor: the matrices of the libraries are slightly
/// inexact. Nothing if the matrix is far from any rotation.
inline std::optional<Quaternion> nearestRotation(Eigen::Matrix3d r) noexcept {
  constexpr double kFarOff = 0.1;
  if (!((r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kFarOff && r.determinant() > 0)) return std::nullopt;
  for (int n = 0; n < 3; ++n) r = 1.5 * r - 0.5 * r * r.transpose() * r;
  return Quaternion(r).normalized();
}

}  // namespace spheretree::device
