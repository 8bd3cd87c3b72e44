// SPDX-License-Identifier: GPL-3.0-or-later
// A surface near a vertex of a mesh: a cubic height field over the tangent plane, through the vertex, fitted to the
// vertices around it. It needs no order and no even spacing of these, as the masks of subdivision surfaces do.
// docs/algorithms/skin/skin.md
// Paper: F. Cazals, M. Pouget. Estimating differential quantities using polynomial fitting of osculating jets.
//        Computer Aided Geometric Design 22(2), 2005.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

namespace spheretree::builder {

class CubicFit {
 public:
  /// `normal` has unit length and is near that of the surface; `around`: points near `origin`, at least three, none of
  /// them equal to it. Deterministic. Cost: 5 us.
  CubicFit(const Eigen::Vector3d& origin, const Eigen::Vector3d& normal, std::span<const Eigen::Vector3d> around);

  struct Point {
    Eigen::Vector3d position, normal;  // unit length
  };
  /// The point of the surface whose foot on the plane is that of `p`.
  Point at(const Eigen::Vector3d& p) const;

 private:
  void fit(std::span<const Eigen::Vector3d> around);

  Eigen::Vector3d origin_;
  double scale_ = 1;                          // mean distance of the points [mm]
  Eigen::Matrix3d frame_;                     // columns: two directions of the plane, its normal
  Eigen::Matrix<double, 9, 1> coefficients_;  // of the monomials x, y, x^2, x y, y^2, x^3, x^2 y, x y^2, y^3, in units of scale_
};

}  // namespace spheretree::builder
