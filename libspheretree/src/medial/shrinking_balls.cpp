// SPDX-License-Identifier: GPL-3.0-or-later
#include "medial/shrinking_balls.h"

#include <cmath>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr int kMaxRounds = 40;   // each round touches at least one new feature; ten rounds are rare
constexpr double kClose = 1e-3;  // a ball counts as inscribed if it is empty up to this share of its radius

}  // namespace

Ball shrinkingBall(const DistanceField& field, const Vector3d& point, const Vector3d& normal, double stand_off) {
  const Vector3d inward = -normal;
  double r = 0.5 * field.diagonal();
  const double vanishing = kVanishing * field.diagonal();
  Vector3d c = point + r * inward;
  for (int round = 0; round < kMaxRounds; ++round) {
    NearestPoint touch = field.nearest(c, (r - stand_off) * (1 - kClose));
    if (!std::isfinite(touch.distance)) {
      // Empty up to the tolerance. But a solid thinner than that share of the radius may lie between the centre and the
      // point.
      const double depth = -field.signedDistance(c, &touch);
      if (depth > 0) return {c, depth};
    }
    const Vector3d to = touch.point - point;
    const double along = to.dot(inward);
    if (!(along > stand_off)) break;  // rounding: the point lies in the tangent plane
    const double smaller = (to.squaredNorm() - stand_off * stand_off) / (2 * (along - stand_off));
    if (!(smaller < r) || smaller < vanishing) break;
    r = smaller;
    c = point + r * inward;
  }
  return {c, 0};
}

Ball touchingBall(const DistanceField& field, const Vector3d& p) {
  const NearestPoint touch = field.nearest(p);
  return shrinkingBall(field, touch.point, field.pseudonormal(touch));
}

}  // namespace spheretree::builder
