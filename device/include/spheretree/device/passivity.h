// SPDX-License-Identifier: Apache-2.0
// Time-domain passivity control: removes, by damping, the energy that sampling, the zero-order hold and a delay add to
// the wrench that the renderer computed. Off by default (SafetySettings): docs/device.md
// Papers: B. Hannaford, J.-H. Ryu. Time-domain passivity control of haptic interfaces. IEEE Trans. Robotics and
//         Automation 18(1), 2002. J.-H. Ryu, C. Preusche, B. Hannaford, G. Hirzinger. Time domain passivity control
//         with reference energy following. IEEE Trans. Control Systems Technology 13(5), 2005.
// Units: mm, N, N mm, s, mJ (= N mm). No allocation. Deterministic.
#pragma once

#include <array>

#include "spheretree/core/rigid.h"

namespace spheretree::device {

inline constexpr double kServoPeriod = 1e-3;  // of a servo step, unless SafetySettings::period says otherwise [s]
inline constexpr int kMaxDelay = 7;           // largest delay: whole servo steps from a pose to the wrench that responds to it

class PassivityControl {
 public:
  PassivityControl() : PassivityControl(0, 0, kServoPeriod) {}
  /// `delay`: 0..kMaxDelay. `max_damping`: of the translation [N s/mm]; the limit for the rotation is kLever^2 times
  /// that. `period`: of a step [s].
  PassivityControl(int delay, double max_damping, double period = kServoPeriod) noexcept;

  /// The wrench to send at this pose in place of `wrench`. Both are about the position of the pose. In each servo step
  /// call control() and then sent(), or, if the pose is unknown, lose() and then sent().
  Wrench control(const Configuration& pose, const Wrench& wrench) noexcept;
  /// The pose of this step is unknown: the next pose does not count as a motion from the last one, and this step adds
  /// nothing.
  void lose(const Wrench& wrench) noexcept;
  /// Reports the wrench that the motors receive: that of control(), possibly reduced by their limits.
  void sent(const Wrench& wrench) noexcept;

  /// The wrench that the last step added; zero if none.
  const Wrench& added() const noexcept { return actions_[0]; }
  /// Energy that was rendered in excess of the intended energy and has yet to be removed [mJ]; negative: less was
  /// rendered.
  double debt() const noexcept;

  static constexpr double kSpan = 8e-3;  // time over which the speed is averaged, so that a single count of an encoder is not a motion [s]
  static constexpr double kLever = 25;   // 1 rad counts as this length, the ratio of the start guard's 5 N mm and 0.2 N [mm]

 private:
  static constexpr int kMaxSpan = 64;  // kSpan in steps of 8 kHz
  int delay_, span_;
  double max_damping_, period_;
  bool has_pose_ = false;
  Configuration pose_;
  Wrench meant_wrench_;           // intended wrench of the step before
  double taken_ = 0, meant_ = 0;  // energy received from the hand: with the wrenches that were sent, and with those that were intended [mJ]
  std::array<Displacement, kMaxSpan> ways_{};    // displacements of the last span_ steps, the latest first
  std::array<Wrench, kMaxDelay + 1> sent_{};     // wrenches of the last steps, the latest first
  std::array<Wrench, kMaxDelay + 1> actions_{};  // the part of them that this class added
};

}  // namespace spheretree::device
