// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/cubic_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using Monomials = Eigen::Matrix<double, 9, 1>;

// A point at the distance d has the weight d^-8, since what a cubic leaves out grows with d^4; points nearer than this
// share of the mean distance have the weight of that distance.
constexpr double kNearest = 0.25;
// Keeps the coefficients that the points do not determine small. They are lengths in units of the mean distance; the
// weights are 1 there.
constexpr double kDamping = 1e-3;

Monomials monomials(double x, double y) {
  Monomials m;
  m << x, y, x * x, x * y, y * y, x * x * x, x * x * y, x * y * y, y * y * y;
  return m;
}

}  // namespace

CubicFit::CubicFit(const Vector3d& origin, const Vector3d& normal, std::span<const Vector3d> around) : origin_(origin) {
  double sum = 0;
  for (const Vector3d& p : around) sum += (p - origin).norm();
  scale_ = sum / static_cast<double>(around.size());
  frame_.col(2) = normal;
  fit(around);
  // Heights over a plane that is tangent to the surface are smaller, and what the cubic leaves out with them.
  frame_.col(2) = at(origin).normal;
  fit(around);
}

void CubicFit::fit(std::span<const Vector3d> around) {
  frame_.col(0) = frame_.col(2).unitOrthogonal();
  frame_.col(1) = frame_.col(2).cross(frame_.col(0));
  Eigen::Matrix<double, 9, 9> squares = Eigen::Matrix<double, 9, 9>::Zero();
  Monomials right = Monomials::Zero();
  squares.diagonal().tail<7>().setConstant(kDamping);
  for (const Vector3d& p : around) {
    const Vector3d local = frame_.transpose() * (p - origin_) / scale_;
    const double square = std::max(local.squaredNorm(), kNearest * kNearest), weight = 1 / (square * square * square * square);
    const Monomials m = monomials(local.x(), local.y());
    squares += weight * m * m.transpose();
    right += weight * local.z() * m;
  }
  coefficients_ = squares.ldlt().solve(right);
}

CubicFit::Point CubicFit::at(const Vector3d& p) const {
  const Vector3d local = frame_.transpose() * (p - origin_) / scale_;
  const double x = local.x(), y = local.y();
  const Monomials& c = coefficients_;
  const double dx = c[0] + 2 * c[2] * x + c[3] * y + 3 * c[5] * x * x + 2 * c[6] * x * y + c[7] * y * y;
  const double dy = c[1] + c[3] * x + 2 * c[4] * y + c[6] * x * x + 2 * c[7] * x * y + 3 * c[8] * y * y;
  const double height = c.dot(monomials(x, y));
  return {p + scale_ * (height - local.z()) * frame_.col(2), (frame_ * Vector3d(-dx, -dy, 1)).normalized()};
}

}  // namespace spheretree::builder
