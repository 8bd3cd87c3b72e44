// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/simulated_device.h"

#include <algorithm>
#include <cmath>

#include "range.h"

namespace spheretree::device {
namespace {

constexpr double kLongestSubstep = 10e-6;  // [s]
constexpr int kLeastSubsteps = 50;         // in a servo step: with 13, the stiffest stable wall is off by 5 %
constexpr double kMmPerM = 1000;

constexpr Hand kHands[] = {
    {.name = "arm", .mass = 0.554, .damping = 6.45, .stiffness = 135},
    {.name = "fine", .mass = 0.15, .damping = 4.5, .stiffness = 300},
    {.name = "light", .mass = 0.05, .damping = 2, .stiffness = 100},
    {.name = "firm", .mass = 1.0, .damping = 15, .stiffness = 1000},
    {.name = "teleoperator", .mass = 2.0, .damping = 2.0, .stiffness = 10},
    {.name = "released", .mass = 0, .damping = 0, .stiffness = 5, .inertia = 0, .angular_damping = 0, .angular_stiffness = 0}};

void check(const SimulatedSettings& s) {
  constexpr double tiny = 1e-9, large = 1e6, endless = std::numeric_limits<double>::infinity();
  const Range ranges[] = {{"mass", s.mass, 1e-3, large},
                          {"inertia", s.inertia, 1e-7, large},
                          {"viscous", s.viscous, 0, 100},
                          {"viscous_rotation", s.viscous_rotation, 0, 1},
                          {"coulomb", s.coulomb, 0, large},
                          {"coulomb_rotation", s.coulomb_rotation, 0, large},
                          {"position_step", s.position_step, 0, large},
                          {"angle_step", s.angle_step.minCoeff(), 0, 1},
                          {"angle_step", s.angle_step.maxCoeff(), 0, 1},
                          {"delay", static_cast<double>(s.delay), 0, 7},
                          {"max_force", s.max_force, tiny, large},
                          {"continuous_force", s.continuous_force, tiny, large},
                          {"max_torque", s.max_torque.minCoeff(), tiny, large},
                          {"continuous_torque", s.continuous_torque.minCoeff(), tiny, large},
                          {"thermal_time", s.thermal_time, 1e-3, large},
                          {"mode_frequency", s.mode_frequency, 0, 500},
                          {"mode_damping", s.mode_damping, 0, 1},
                          {"jitter", s.jitter, 0, 4e-4},
                          {"lost_steps", s.lost_steps, 0, 0.5},
                          {"hand.mass", s.hand.mass, 0, large},
                          {"hand.damping", s.hand.damping, 0, 1000},
                          {"hand.stiffness", s.hand.stiffness, 0, large},
                          {"hand.inertia", s.hand.inertia, 0, large},
                          {"hand.angular_damping", s.hand.angular_damping, 0, 1},
                          {"hand.angular_stiffness", s.hand.angular_stiffness, 0, 1000},
                          {"release_at", s.release_at, 0, endless},
                          {"duration", s.duration, tiny, endless}};
  if (const std::string fault = outOfRange(ranges); !fault.empty()) throw DeviceError(DeviceFault::Refused, "simulated device: " + fault);
}

double quantised(double value, double step) noexcept { return step > 0 ? std::round(value / step) * step : value; }

/// Implicit Coulomb friction over a substep: its impulse reduces the speed, at most to zero. A body therefore sticks
/// without a threshold speed, and never chatters.
Eigen::Vector3d rubbed(const Eigen::Vector3d& velocity, double loss) noexcept {
  Eigen::Vector3d out;
  for (int k = 0; k < 3; ++k) out[k] = std::copysign(std::max(0.0, std::abs(velocity[k]) - loss), velocity[k]);
  return out;
}

}  // namespace

std::span<const Hand> hands() noexcept { return kHands; }

std::optional<Hand> findHand(std::string_view name) noexcept {
  for (const Hand& hand : kHands)
    if (name == hand.name) return hand;
  return std::nullopt;
}

SimulatedDevice::SimulatedDevice(const SimulatedSettings& settings) : settings_(settings) {
  check(settings_);
  if (!settings_.path) settings_.path = [](double) { return Configuration(); };
  if (!isFinite(settings_.path(0))) throw DeviceError(DeviceFault::Refused, "simulated device: the path does not begin at a finite pose");
  info_ = {.model = "simulated device",
           .serial = "",
           .driver = "",
           .max_force = settings_.max_force,
           .continuous_force = settings_.continuous_force,
           .max_torque = settings_.max_torque,
           .continuous_torque = settings_.continuous_torque,
           .delay = settings_.delay};
  SimulatedDevice::rewind();
}

/// A servo step is a whole number of substeps.
void SimulatedDevice::begin(Clock) {
  if (settings_.jitter > 0.4 * period())
    throw DeviceError(DeviceFault::Refused,
                      "simulated device: jitter is longer than 0.4 of a servo step: make it shorter, or the rate lower");
  substeps_ = std::max(kLeastSubsteps, static_cast<int>(std::ceil(period() / kLongestSubstep - 1e-6)));
  substep_ = period() / substeps_;
  rewind();
}

void SimulatedDevice::rewind() noexcept {
  const Configuration first = settings_.path(0);
  handle_ = motor_ = {first.position};
  orientation_ = home_ = first.orientation.normalized();
  turn_rate_.setZero();
  pending_.fill({});
  held_ = {};
  heat_.setZero();
  steps_ = 0;
  random_state_ = settings_.seed;
  time_ = energy_ = 0;
  substeps_ahead_ = 0;
}

bool SimulatedDevice::advance() noexcept {
  if (static_cast<double>(steps_) * period() >= settings_.duration) return false;
  // Drawn before the wrench is computed, so that the random numbers do not depend on it.
  const bool lost = settings_.lost_steps > 0 && random() < settings_.lost_steps;
  const int next_ahead = settings_.jitter > 0 ? static_cast<int>(std::lround((2 * random() - 1) * settings_.jitter / substep_)) : 0;
  if (!lost) {
    const std::size_t slot = steps_ % pending_.size();
    pending_[slot] = commanded(tick(measured()));
    held_ = pending_[(slot + pending_.size() - static_cast<std::size_t>(settings_.delay)) % pending_.size()];
  } else {
    pending_[steps_ % pending_.size()] = pending_[(steps_ + pending_.size() - 1) % pending_.size()];
  }
  move(substeps_ + next_ahead - substeps_ahead_);
  substeps_ahead_ = next_ahead;
  heat();
  ++steps_;
  return true;
}

DeviceState SimulatedDevice::measured() const noexcept {
  DeviceState state;
  for (int k = 0; k < 3; ++k) state.handle.position[k] = quantised(motor_.position[k], settings_.position_step);
  // Quantises a rotation from home: unlike gimbal angles it has no singular pose, and the same resolution.
  Eigen::Vector3d turn = rotationVector(home_.conjugate() * orientation_);
  for (int k = 0; k < 3; ++k) turn[k] = quantised(turn[k], settings_.angle_step[k]);
  state.handle.orientation = (home_ * rotationOf(turn)).normalized();
  state.temperature = heat_.maxCoeff();
  return state;
}

/// Saturation, and quantisation to the 16 bits of the command.
Wrench SimulatedDevice::commanded(const Wrench& wrench) const noexcept {
  const auto bits = [](double value, double largest) {
    return std::clamp(std::round(value / largest * 32767), -32767.0, 32766.0) / 32767 * largest;
  };
  Wrench out;
  const double force = wrench.force.norm();
  const double scale = force > settings_.max_force ? settings_.max_force / force : 1;
  for (int k = 0; k < 3; ++k) out.force[k] = bits(scale * wrench.force[k], settings_.max_force);
  Eigen::Vector3d torque = orientation_.conjugate() * wrench.torque;
  for (int k = 0; k < 3; ++k) torque[k] = bits(torque[k], settings_.max_torque[k]);
  out.torque = orientation_ * torque;
  return out;
}

void SimulatedDevice::move(int substeps) noexcept {
  const Hand hand = time_ < settings_.release_at ? settings_.hand : kHands[std::size(kHands) - 1];
  const double span = substeps * substep_;
  const Configuration from = settings_.path(time_), to = settings_.path(time_ + span);
  const Body motor = motor_;
  const Quaternion orientation = orientation_;
  moveTranslation(substeps, hand, from.position, (to.position - from.position) / span);
  moveRotation(substeps, hand, from, to);
  energy_ -= held_.force.dot(motor_.position - motor.position) + held_.torque.dot(rotationVector(orientation_ * orientation.conjugate()));
  time_ += span;
}

void SimulatedDevice::moveTranslation(int substeps, const Hand& hand, const Eigen::Vector3d& target,
                                      const Eigen::Vector3d& target_velocity) noexcept {
  const bool rigid = settings_.mode_frequency <= 0;
  const double motor_mass = rigid ? settings_.mass + hand.mass : settings_.mass / 2, handle_mass = settings_.mass / 2 + hand.mass;
  // The mode of the bare device: two halves of the mass on a spring, hence a reduced mass of a quarter.
  const double omega = 2 * M_PI * settings_.mode_frequency;
  const double spring = omega * omega * settings_.mass / 4 / kMmPerM,
               damper = 2 * settings_.mode_damping * omega * settings_.mass / 4 / kMmPerM;
  const double hand_spring = hand.stiffness / kMmPerM, hand_damper = hand.damping / kMmPerM, viscous = settings_.viscous / kMmPerM;
  Eigen::Vector3d goal = target;
  for (int n = 0; n < substeps; ++n, goal += target_velocity * substep_) {
    const Body& held = rigid ? motor_ : handle_;
    const Eigen::Vector3d by_hand = hand_spring * (goal - held.position) + hand_damper * (target_velocity - held.velocity);
    const Eigen::Vector3d on_motor =
        held_.force - viscous * motor_.velocity +
        (rigid ? by_hand : Eigen::Vector3d(spring * (handle_.position - motor_.position) + damper * (handle_.velocity - motor_.velocity)));
    if (!rigid) {
      const Eigen::Vector3d by_motor = spring * (motor_.position - handle_.position) + damper * (motor_.velocity - handle_.velocity);
      handle_.velocity += (by_hand + by_motor) * (kMmPerM * substep_ / handle_mass);
      handle_.position += handle_.velocity * substep_;
    }
    motor_.velocity =
        rubbed(motor_.velocity + on_motor * (kMmPerM * substep_ / motor_mass), settings_.coulomb * kMmPerM * substep_ / motor_mass);
    motor_.position += motor_.velocity * substep_;
  }
  if (rigid) handle_ = motor_;
}

void SimulatedDevice::moveRotation(int substeps, const Hand& hand, const Configuration& from, const Configuration& to) noexcept {
  // In N m. Over one servo step the rotation is small: rotation vectors from its beginning add up like translations.
  const double inertia = settings_.inertia + hand.inertia;
  const Eigen::Vector3d torque = held_.torque / kMmPerM;
  const Eigen::Vector3d target_rate = rotationVector(to.orientation * from.orientation.conjugate()) / (substeps * substep_);
  Eigen::Vector3d goal = rotationVector(from.orientation * orientation_.conjugate()), turned = Eigen::Vector3d::Zero();
  for (int n = 0; n < substeps; ++n, goal += target_rate * substep_) {
    const Eigen::Vector3d by_hand = hand.angular_stiffness * (goal - turned) + hand.angular_damping * (target_rate - turn_rate_);
    const Eigen::Vector3d all = torque + by_hand - settings_.viscous_rotation * turn_rate_;
    turn_rate_ = rubbed(turn_rate_ + all * (substep_ / inertia), settings_.coulomb_rotation / kMmPerM * substep_ / inertia);
    turned += turn_rate_ * substep_;
  }
  orientation_ = (rotationOf(turned) * orientation_).normalized();
}

/// Heating is proportional to the square of the current. The continuous load leads to 0.7.
void SimulatedDevice::heat() noexcept {
  constexpr double kSteady = 0.7;
  const Eigen::Vector3d torque = orientation_.conjugate() * held_.torque;
  for (int k = 0; k < 6; ++k) {
    const double load = k < 3 ? held_.force[k] / settings_.continuous_force : torque[k - 3] / settings_.continuous_torque[k - 3];
    heat_[k] = std::min(1.0, heat_[k] + (kSteady * load * load - heat_[k]) * (period() / settings_.thermal_time));
  }
}

double SimulatedDevice::random() noexcept {  // splitmix64, Steele, Lea and Flood 2014
  std::uint64_t z = (random_state_ += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

}  // namespace spheretree::device
