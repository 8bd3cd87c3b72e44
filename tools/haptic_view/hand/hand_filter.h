// SPDX-License-Identifier: GPL-3.0-or-later
// From where an input says that the hand means to be to where a hand can mean to be: a mouse of 60 Hz is a staircase of
// 16 ms, and a hand moves neither in steps nor without limit. Units: mm, rad, s.
#pragma once

#include "spheretree/core/rigid.h"

namespace spheretree::view {

/// A critically damped second-order filter of 8 Hz for position and orientation, at most 300 mm/s and 6 rad/s. It never
/// overshoots a target that rests. No allocation.
class HandFilter {
 public:
  static constexpr double kFrequency = 8, kFastest = 300, kFastestTurn = 6;

  /// At rest there.
  void resetTo(const Configuration& pose) noexcept;
  /// `seconds` later.
  const Configuration& towards(const Configuration& target, double seconds) noexcept;
  const Configuration& pose() const noexcept { return pose_; }

 private:
  Configuration pose_;
  Eigen::Vector3d speed_ = Eigen::Vector3d::Zero(), turn_rate_ = Eigen::Vector3d::Zero();
};

}  // namespace spheretree::view
