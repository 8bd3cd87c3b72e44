// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/passivity.h"

#include <algorithm>

#include "spheretree/device/safety.h"

namespace spheretree::device {
namespace {

/// What the hand puts in on this way against a wrench on it [mJ].
double energyOf(const Wrench& wrench, const Displacement& way) noexcept {
  return -wrench.force.dot(way.translation) - wrench.torque.dot(way.rotation);
}

bool isZero(const Wrench& wrench) noexcept { return wrench.force.isZero(0) && wrench.torque.isZero(0); }

}  // namespace

double PassivityControl::debt() const noexcept { return std::max(meant_, 0.0) - taken_; }

// A renderer whose wrench followed the motion without holds and delays would exchange what the trapezoid between two
// poses says: for a spring to the bit. What was sent may not have taken less, nor less than nothing.
Wrench PassivityControl::control(const Configuration& pose, const Wrench& wrench) noexcept {
  const Displacement way = has_pose_ ? displacementBetween(pose_, pose) : Displacement();
  const auto delay = static_cast<std::size_t>(delay_);
  taken_ += energyOf(sent_[delay], way);
  meant_ += 0.5 * (energyOf(meant_wrench_, way) + energyOf(wrench, way));
  pose_ = pose;
  has_pose_ = true;
  meant_wrench_ = wrench;
  if (isZero(wrench) && std::all_of(sent_.begin(), sent_.end(), isZero)) {  // at rest: debts stay, what was taken is gone
    taken_ = std::min(0.0, -debt());
    meant_ = 0;
  }
  double owed = debt();
  for (std::size_t k = 0; k < delay; ++k) owed -= energyOf(actions_[k], way);  // on its way to the motors
  std::shift_right(ways_.begin(), ways_.end(), 1);
  ways_[0] = way;
  Displacement mean;
  for (const Displacement& w : ways_) {
    mean.translation += w.translation / kSpan;
    mean.rotation += w.rotation / kSpan;
  }
  const double square = mean.translation.squaredNorm() + kLever * kLever * mean.rotation.squaredNorm();
  if (!(owed > 0 && square > 0) || isZero(wrench)) return wrench;
  // On a way like the last ones this takes what is owed.
  const double damping = std::min(owed / square, most_damping_ / kServoPeriod);
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
