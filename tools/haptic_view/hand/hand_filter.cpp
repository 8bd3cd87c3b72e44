// SPDX-License-Identifier: GPL-3.0-or-later
#include "hand/hand_filter.h"

#include <cmath>
#include <numbers>

namespace spheretree::view {
namespace {

constexpr double kOmega = 2 * std::numbers::pi * HandFilter::kFrequency;  // [rad/s]

/// The exact solution of x'' = omega^2 (0 - x) - 2 omega x' after `dt`; returns the displacement, at most `fastest` *
/// dt.
Eigen::Vector3d step(const Eigen::Vector3d& from_target, Eigen::Vector3d& speed, double dt, double fastest) {
  const double decay = std::exp(-kOmega * dt);
  const Eigen::Vector3d j = (speed + kOmega * from_target) * dt;
  Eigen::Vector3d way = (from_target + j) * decay - from_target;
  speed = (speed - kOmega * j) * decay;
  const double length = way.norm(), largest = fastest * dt;
  if (length > largest) way *= largest / length;
  if (speed.norm() > fastest) speed *= fastest / speed.norm();
  return way;
}

}  // namespace

void HandFilter::resetTo(const Configuration& pose) noexcept {
  pose_ = pose;
  speed_.setZero();
  turn_rate_.setZero();
}

const Configuration& HandFilter::towards(const Configuration& target, double seconds) noexcept {
  if (!(seconds > 0)) return pose_;
  const Displacement to_target = displacementBetween(pose_, target);
  const Eigen::Vector3d way = step(-to_target.translation, speed_, seconds, kFastest);
  const Eigen::Vector3d turn = step(-to_target.rotation, turn_rate_, seconds, kFastestTurn);
  pose_ = moved(pose_, {way, turn});
  return pose_;
}

}  // namespace spheretree::view
