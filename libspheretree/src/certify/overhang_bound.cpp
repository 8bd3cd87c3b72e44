// SPDX-License-Identifier: GPL-3.0-or-later
#include "certify/overhang_bound.h"

namespace spheretree::builder {

namespace {

constexpr double kRounding =
    1e-12;  // larger than the relative error of a signed distance, as a share of the largest length (distance_field.h)

}  // namespace

double overhangBound(const DistanceField& field, const Eigen::Vector3d& origin, const Sphere& sphere) {
  const Eigen::Vector3d c = Eigen::Vector3d(sphere.x, sphere.y, sphere.z) + origin;
  const double rounding = kRounding * (c.cwiseAbs().maxCoeff() + field.diagonal());
  return sphere.radius + field.signedDistance(c) + rounding;
}

}  // namespace spheretree::builder
