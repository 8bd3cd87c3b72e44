// SPDX-License-Identifier: GPL-3.0-or-later
// Smooths the target of an input to a path that a hand can make: a mouse of 60 Hz gives a staircase of 16 ms, but a
// hand does not move in steps, and its speed is limited. Units: mm, rad, s.
#pragma once

#include "spheretree/core/rigid.h"

namespace spheretree::view {

/// A critically damped second-order filter of 8 Hz for position and orientation, limited to 300 mm/s and 6 rad/s. It
/// does not overshoot a constant target. No allocation.
class HandFilter {
 public:
  static constexpr double kFrequency = 8, kFastest = 300, kFastestTurn = 6;

  /// Sets the pose, at rest.
  void resetTo(const Configuration& pose) noexcept;
  /// Moves towards the target for `seconds`.
  const Configuration& towards(const Configuration& target, double seconds) noexcept;
  const Configuration& pose() const noexcept { return pose_; }

 private:
  Configuration pose_;
  Eigen::Vector3d speed_ = Eigen::Vector3d::Zero(), turn_rate_ = Eigen::Vector3d::Zero();
};

}  // namespace spheretree::view
