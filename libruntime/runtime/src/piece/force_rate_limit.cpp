// SPDX-License-Identifier: Apache-2.0
#include "piece/force_rate_limit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spheretree::runtime {
namespace {

// The largest share of `way`, up to `max_share`, after which |changed - share way| is at most the limit.
template <int kSize>
double shareOf(const double* changed_at, const double* way_at, double limit, double max_share) {
  const Eigen::Map<const Eigen::Matrix<double, kSize, 1>> changed(changed_at), way(way_at);
  const double square = way.squaredNorm();
  if (!(square > 0) || (changed - max_share * way).norm() <= limit) return max_share;
  const double along = changed.dot(way), left = limit * limit - changed.squaredNorm();
  return std::clamp((along + std::sqrt(std::max(0.0, along * along + square * left))) / square, 0.0, max_share);
}

}  // namespace

// Force and torque change by no more than they could if the free poses were a convex set, or than the hand's motion and
// the perception threshold allow. The projection on a convex set is firmly non-expansive: a motion d of the hand
// changes the stretch by an s with |s - d/2| <= |d|/2.
ForceRateLimit::ForceRateLimit(const Coupling& pull, double angle_length, const Vector6& before, const Vector6& hand,
                               const Vector6& at_rest)
    : before_(before) {
  const Vector6 change = at_rest - before;
  const double both = std::max(hand.norm(), change.norm()), translation = hand.head<3>().norm(),
               rotation = std::max(hand.tail<3>().norm(), change.tail<3>().norm());
  const double force = translation + std::max(kForceStep / pull.translation, kForceStepPart * before.head<3>().norm()),
               torque = rotation + std::max(kTorqueStep * angle_length / pull.rotation, kTorqueStepPart * before.tail<3>().norm());
  both_ = std::max(both, force);
  force_ = std::max((both + translation) / 2, force);
  torque_ = std::max((both + rotation) / 2, torque);
}

void ForceRateLimit::lift() { both_ = force_ = torque_ = std::numeric_limits<double>::infinity(); }

void ForceRateLimit::allow(const Vector6& motion) {
  both_ += motion.norm();
  force_ += motion.head<3>().norm();
  torque_ += motion.tail<3>().norm();
}

double ForceRateLimit::shareWithin(const Vector6& stretch, const Vector6& way, double max_share) const {
  const Vector6 changed = stretch - before_;
  max_share = shareOf<6>(changed.data(), way.data(), both_, max_share);
  max_share = shareOf<3>(changed.data(), way.data(), force_, max_share);
  return shareOf<3>(changed.data() + 3, way.data() + 3, torque_, max_share);
}

}  // namespace spheretree::runtime
