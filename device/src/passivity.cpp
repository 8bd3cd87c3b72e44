// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/passivity.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace spheretree::device {
namespace {

/// Energy that the hand spends on this way against a wrench on it [mJ].
double energyOf(const Wrench& wrench, const Displacement& way) noexcept {
  return -wrench.force.dot(way.translation) - wrench.torque.dot(way.rotation);
}

bool isZero(const Wrench& wrench) noexcept { return wrench.force.isZero(0) && wrench.torque.isZero(0); }

}  // namespace

PassivityControl::PassivityControl(int delay, double max_damping, double period) noexcept
    : delay_(delay),
      span_(std::clamp(static_cast<int>(std::lround(kSpan / period)), 1, kMaxSpan)),
      max_damping_(max_damping),
      period_(period) {}

double PassivityControl::debt() const noexcept { return std::max(meant_, 0.0) - taken_; }

// The reference is a renderer whose wrench follows the motion without hold and delay: its energy is given by the
// trapezoidal rule between two poses, which is exact for a spring. The wrenches that were sent must not have absorbed
// less energy than that, nor less than zero.
Wrench PassivityControl::control(const Configuration& pose, const Wrench& wrench) noexcept {
  const Displacement way = has_pose_ ? displacementBetween(pose_, pose) : Displacement();
  const auto delay = static_cast<std::size_t>(delay_);
  taken_ += energyOf(sent_[delay], way);
  meant_ += 0.5 * (energyOf(meant_wrench_, way) + energyOf(wrench, way));
  pose_ = pose;
  has_pose_ = true;
  meant_wrench_ = wrench;
  if (isZero(wrench) && std::all_of(sent_.begin(), sent_.end(), isZero)) {  // at rest: the debt is kept, and the absorbed energy is reset
    taken_ = std::min(0.0, -debt());
    meant_ = 0;
  }
  double owed = debt();
  for (std::size_t k = 0; k < delay; ++k) owed -= energyOf(actions_[k], way);  // still on the way to the motors
  const std::span<Displacement> ways = std::span(ways_).first(static_cast<std::size_t>(span_));
  std::shift_right(ways.begin(), ways.end(), 1);
  ways[0] = way;
  Displacement mean;
  for (const Displacement& w : ways) {
    mean.translation += w.translation / span_;
    mean.rotation += w.rotation / span_;
  }
  const double square = mean.translation.squaredNorm() + kLever * kLever * mean.rotation.squaredNorm();
  if (!(owed > 0 && square > 0) || isZero(wrench)) return wrench;
  // On a way like the last ones, this removes the debt.
  const double damping = std::min(owed / square, max_damping_ / period_);
  return {wrench.force - damping * mean.translation, wrench.torque - damping * kLever * kLever * mean.rotation};
}

void PassivityControl::lose(const Wrench& wrench) noexcept {
  has_pose_ = false;
  meant_wrench_ = wrench;
}

void PassivityControl::sent(const Wrench& wrench) noexcept {
  std::shift_right(sent_.begin(), sent_.end(), 1);
  std::shift_right(actions_.begin(), actions_.end(), 1);
  sent_[0] = wrench;
  actions_[0] = {wrench.force - meant_wrench_.force, wrench.torque - meant_wrench_.torque};
}

}  // namespace spheretree::device
