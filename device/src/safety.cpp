// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/safety.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "range.h"

namespace spheretree::device {
namespace {

constexpr double kLargest = 1e6;
constexpr double kCalmMs = 3;
constexpr double kRestForce = 1e-3, kRestTorque = 0.05;  // below the smallest command of a 16-bit device [N, N mm]

/// `to`, or the nearest wrench that is reached by a decrease followed by an increase of at most `rise`. A decrease is
/// not limited, since it is the safe direction.
Eigen::Vector3d risen(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double rise) {
  const double square = from.squaredNorm();
  const Eigen::Vector3d fallen = square > 0 ? Eigen::Vector3d(from * std::clamp(from.dot(to) / square, 0.0, 1.0)) : from;
  const Eigen::Vector3d change = to - fallen;
  const double length = change.norm();
  return length <= rise ? to : Eigen::Vector3d(fallen + change * (rise / length));
}

bool isFinite(const Wrench& wrench) { return wrench.force.allFinite() && wrench.torque.allFinite(); }

}  // namespace

std::string findFault(const SafetySettings& s) {
  constexpr double tiny = 1e-9;
  const Range ranges[] = {{"period", s.period, 1.0 / 8000, 1.0 / 500},
                          {"max_force", s.max_force, tiny, kLargest},
                          {"max_torque x", s.max_torque.x(), tiny, kLargest},
                          {"max_torque y", s.max_torque.y(), tiny, kLargest},
                          {"max_torque z", s.max_torque.z(), tiny, kLargest},
                          {"continuous_force", s.continuous_force, tiny, kLargest},
                          {"continuous_torque x", s.continuous_torque.x(), tiny, kLargest},
                          {"continuous_torque y", s.continuous_torque.y(), tiny, kLargest},
                          {"continuous_torque z", s.continuous_torque.z(), tiny, kLargest},
                          {"force_slew", s.force_slew, tiny, kLargest},
                          {"torque_slew", s.torque_slew, tiny, kLargest},
                          {"contact_start", s.contact_start, 0, 1},
                          {"guard_force", s.guard_force, tiny, kLargest},
                          {"guard_torque", s.guard_torque, tiny, kLargest},
                          {"ramp", s.ramp, kServoPeriod, 60},
                          {"ramp_force_slew", s.ramp_force_slew, tiny, kLargest},
                          {"ramp_torque_slew", s.ramp_torque_slew, tiny, kLargest},
                          {"stale_after", s.stale_after, tiny, kLargest},
                          {"stale_fade", s.stale_fade, tiny, kLargest},
                          {"off_after", s.off_after, tiny, kLargest},
                          {"hold", s.hold, 0, kLargest},
                          {"fade_speed", s.fade_speed, tiny, kLargest},
                          {"fade_force", s.fade_force, tiny, kLargest},
                          {"fade_time", s.fade_time, kServoPeriod, 60},
                          {"pose_jump", s.pose_jump, tiny, kLargest},
                          {"warm", s.warm, tiny, 1},
                          {"cool", s.cool, tiny, s.warm},
                          {"thermal_rate", s.thermal_rate, tiny, 0.5},
                          {"carried_weight", s.carried_weight, 0, 5},
                          {"passivity_damping", s.passivity_damping, tiny, kLargest},
                          {"delay", static_cast<double>(s.delay), 0, kMaxDelay}};
  return outOfRange(ranges);
}

Safety::Safety(const SafetySettings& settings) noexcept
    : settings_(settings),
      in_ms_(settings.period / kServoPeriod),
      thermal_step_(std::pow(1 - settings.thermal_rate, in_ms_)),
      guarded_(settings.start_guard),
      gain_(settings.start_guard ? 0 : 1),
      passivity_(settings.delay, settings.passivity_damping, settings.period) {}

void Safety::rearm() noexcept {
  if (!off_) return;
  off_ = false;
  restart();
}

void Safety::restart() noexcept {
  guarded_ = true;
  calm_steps_ = 0;
  gain_ = 0;
}

Wrench Safety::limit(const DeviceState& state, const Rendered& rendered) noexcept {
  events_ = 0;
  double elapsed = state.time - last_time_;
  if (!(elapsed >= settings_.period)) elapsed = settings_.period;  // the minimum is one period, even if the clock reports less or NaN
  last_time_ = state.time;
  followTemperature(state.temperature);
  const double fresh = freshness(state.age, rendered, elapsed);
  Wrench out, lift;
  if (mayRender(state, elapsed)) {
    const Wrench wanted = clamped(valid_, state.handle.orientation, true);
    if (guardPassed(wanted)) {
      moveGain(fresh, wanted.force.norm());
      out = clamped(slewed({gain_ * wanted.force, gain_ * wanted.torque}), state.handle.orientation, false);
      lift.force.y() = gain_ * settings_.carried_weight;
    }
  }
  if (settings_.passivity_control) out = controlled(state.handle, out);
  sent_ = out;
  followContact(elapsed);
  // The weight is no contact, which the rules above are about; it ends with the forces and returns by the ramp.
  if (lift.force.isZero(0)) return sent_;
  return clamped({sent_.force + lift.force, sent_.torque}, state.handle.orientation, false);
}

/// The last rule, since it must know the wrench that is sent.
Wrench Safety::controlled(const Configuration& handle, const Wrench& wrench) noexcept {
  Wrench out = wrench;
  if (events_ & kBadPose)
    passivity_.lose(wrench);
  else
    out = passivity_.control(handle, wrench);
  const bool is_changed = out.force != wrench.force || out.torque != wrench.torque;
  if (is_changed) out = clamped(out, handle.orientation, false);
  passivity_.sent(out);
  if (is_changed) events_ |= kPassivityControl;
  return out;
}

/// The rules that require zero.
bool Safety::mayRender(const DeviceState& state, double elapsed) noexcept {
  if (state.failed) device_failed_ = true;
  if (device_failed_) events_ |= kDeviceFailed;
  if (halted_) events_ |= kEmergencyStop;
  if (off_) events_ |= kForcesOff;
  if (state.released || (state.buttons & (settings_.release_buttons | settings_.clutch_buttons))) {
    events_ |= kReleased;
    restart();
  }
  if (!spheretree::isFinite(state.handle)) {
    events_ |= kBadPose;
    has_position_ = false;
    restart();
  } else {
    const double path = has_position_ ? (state.handle.position - last_position_).norm() : 0;
    speed_ = path / elapsed;
    if (speed_ * kServoPeriod > settings_.pose_jump) {
      events_ |= kBadPose;
      restart();
    }
    last_position_ = state.handle.position;
    has_position_ = true;
  }
  return (events_ & (kDeviceFailed | kEmergencyStop | kForcesOff | kReleased | kBadPose)) == 0;
}

/// 1: the wrench is fresh; 0: too old to be rendered at all. Keeps the last valid wrench.
double Safety::freshness(double pose_age, const Rendered& rendered, double elapsed) noexcept {
  if (rendered.failed || !isFinite(rendered.wrench)) {
    failing_ += elapsed;
    events_ |= kRendererFailed;
  } else {
    failing_ = 0;
    valid_ = rendered.wrench;
  }
  // A delay of the servo loop itself, and of the device, counts like old contacts.
  double age = elapsed > settings_.stale_after ? elapsed : 0;
  for (const double other : {rendered.model_age, pose_age})
    if (!(other <= age)) age = std::isnan(other) ? std::numeric_limits<double>::infinity() : other;
  if (age > settings_.stale_after) events_ |= kStaleModel;
  if (age > settings_.off_after || failing_ > settings_.off_after) off_ = true;
  const double overdue = std::max(age - settings_.stale_after, failing_ - settings_.hold);
  return std::clamp(1 - overdue / settings_.stale_fade, 0.0, 1.0);
}

bool Safety::guardPassed(const Wrench& wrench) noexcept {
  if (!guarded_) return true;
  const bool calm = wrench.force.norm() < settings_.guard_force && wrench.torque.norm() < settings_.guard_torque;
  calm_steps_ = calm ? calm_steps_ + 1 : 0;
  if (calm_steps_ * in_ms_ > kCalmMs) {
    guarded_ = false;
    return true;
  }
  events_ |= kStartGuard;
  return false;
}

void Safety::moveGain(double freshness, double force) noexcept {
  if (speed_ > settings_.fade_speed && force > settings_.fade_force) {
    events_ |= kTooFast;
    gain_ = std::max(0.0, gain_ - settings_.period / settings_.fade_time);
  } else if (gain_ < 1) {
    gain_ = std::min(1.0, gain_ + settings_.period / settings_.ramp);
  }
  gain_ = std::min(gain_, freshness);
  if (gain_ < 1) events_ |= kRamp;
}

void Safety::followTemperature(double temperature) noexcept {
  if (!(temperature <= settings_.warm)) warm_ = true;  // also if it is NaN
  if (temperature < settings_.cool) warm_ = false;
  const double lowest = std::min(
      {1.0, settings_.continuous_force / settings_.max_force, settings_.continuous_torque.cwiseQuotient(settings_.max_torque).minCoeff()});
  thermal_ = warm_ ? std::max(lowest, thermal_ * thermal_step_) : std::min(1.0, thermal_ / thermal_step_);
  if (thermal_ < 1) events_ |= kWarmMotors;
}

Wrench Safety::clamped(const Wrench& wrench, const Quaternion& handle, bool report) noexcept {
  const auto limit = [this](double largest, double continuous) { return std::max(thermal_ * largest, std::min(largest, continuous)); };
  Wrench out = wrench;
  const double largest = limit(settings_.max_force, settings_.continuous_force);
  // stableNorm: the square of 1e200 N overflows, and a zero wrench in place of a large one would also be a kick.
  if (const double force = wrench.force.stableNorm(); force > largest) {
    out.force = wrench.force / force * largest;
    if (report) events_ |= kForceClamped;
  }
  const double scale = std::max(1.0, wrench.torque.cwiseAbs().maxCoeff());
  const Eigen::Vector3d torque = handle.normalized().conjugate() * (wrench.torque / scale);
  double excess = 1;
  for (int k = 0; k < 3; ++k)
    excess = std::max(excess, std::abs(torque[k]) * (scale / limit(settings_.max_torque[k], settings_.continuous_torque[k])));
  if (excess > 1) {
    out.torque = wrench.torque / excess;
    if (report) events_ |= kTorqueClamped;
  }
  return out;
}

Wrench Safety::slewed(const Wrench& wrench) noexcept {
  if (quick_ && gain_ >= 1) return wrench;
  const bool ramping = gain_ < 1;
  const Wrench out{risen(sent_.force, wrench.force, in_ms_ * (ramping ? settings_.ramp_force_slew : settings_.force_slew)),
                   risen(sent_.torque, wrench.torque, in_ms_ * (ramping ? settings_.ramp_torque_slew : settings_.torque_slew))};
  if (out.force != wrench.force || out.torque != wrench.torque) events_ |= kSlewLimited;
  return out;
}

/// A contact that follows a rest begins with a real impact, which the slew limit would soften. A flickering contact
/// does not.
void Safety::followContact(double elapsed) noexcept {
  const bool nothing = sent_.force.norm() < kRestForce && sent_.torque.norm() < kRestTorque;
  if (nothing) {
    rest_ = contact_ > 0 ? elapsed : rest_ + elapsed;
    contact_ = 0;
    quick_ = settings_.contact_start > 0 && rest_ >= settings_.contact_start;
  } else {
    contact_ += elapsed;
    quick_ = quick_ && contact_ < settings_.contact_start;
  }
}

}  // namespace spheretree::device
