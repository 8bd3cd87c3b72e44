// SPDX-License-Identifier: Apache-2.0
// Time-domain passivity control: takes back, by damping, the energy that sampling, the hold and a delay add to what a
// renderer means. Off unless SafetySettings ask for it: docs/device.md
// Papers: B. Hannaford, J.-H. Ryu. Time-domain passivity control of haptic interfaces. IEEE Trans. Robotics and
//         Automation 18(1), 2002. J.-H. Ryu, C. Preusche, B. Hannaford, G. Hirzinger. Time domain passivity control
//         with reference energy following. IEEE Trans. Control Systems Technology 13(5), 2005.
// Units: mm, N, N mm, s, mJ (= N mm). No allocation. Deterministic.
#pragma once

#include <array>

#include "spheretree/core/rigid.h"

namespace spheretree::device {

inline constexpr int kMostDelay = 7;  // whole servo steps from a pose to the wrench that answers it

class PassivityControl {
 public:
  PassivityControl() : PassivityControl(0, 0) {}
  /// `delay`: 0..kMostDelay. `most_damping`: of the translation [N s/mm]; of the rotation kLever^2 times as much.
  PassivityControl(int delay, double most_damping) noexcept : delay_(delay), most_damping_(most_damping) {}

  /// What is to be sent at this pose in place of `wrench`. Both about the position of the pose. Each servo step calls
  /// it, then sent(); or lose() and sent() if the pose is not known.
  Wrench control(const Configuration& pose, const Wrench& wrench) noexcept;
  /// The next pose is no motion from the last one, and nothing was added in this step.
  void lose(const Wrench& wrench) noexcept;
  /// What the motors get: as control() said, or less within their limits.
  void sent(const Wrench& wrench) noexcept;

  /// Of the last step: what was added to the wrench; zero: nothing.
  const Wrench& added() const noexcept { return actions_[0]; }
  /// Energy that was given beyond what the renderer means, and is to be taken back; below 0: less was given [mJ].
  double debt() const noexcept;

  static constexpr int kSpan = 8;       // steps over which the speed is taken: an encoder's count is no motion
  static constexpr double kLever = 25;  // 1 rad weighs as much as this way: the start guard's 5 N mm by its 0.2 N [mm]

 private:
  int delay_;
  double most_damping_;
  bool has_pose_ = false;
  Configuration pose_;
  Wrench meant_wrench_;                           // of the step before
  double taken_ = 0, meant_ = 0;                  // from the hand, by what was sent and by what is meant [mJ]
  std::array<Displacement, kSpan> ways_{};        // of the last steps, the latest first
  std::array<Wrench, kMostDelay + 1> sent_{};     // of the last steps, the latest first
  std::array<Wrench, kMostDelay + 1> actions_{};  // this much of it was added
};

}  // namespace spheretree::device
