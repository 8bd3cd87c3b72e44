// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/measure_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "spheretree/device/emergency_stop.h"

namespace spheretree::player {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMostForce = 1;        // [N]
constexpr double kMostSpeed = 12;       // to which a push leads [mm/s]
constexpr double kRestSeconds = 3;      // guard and ramp of the device are over
constexpr double kPushRate = 0.1;       // rise of the force that looks for friction [N/s]
constexpr double kMoved = 0.03;         // a handle that went so far was moved [mm]
constexpr double kStepForce = 0.2;      // [N]
constexpr double kPreload = 0.8;        // share of the friction that is overcome before the step
constexpr double kSettleSeconds = 0.1;  // with the preload, and after a push
constexpr double kTraceSeconds = 0.06;  // in which a motion is watched
constexpr std::size_t kTrialsOfLength = 4;
constexpr double kFineness = 1e-5;     // of the latency [s]
constexpr double kBrake = 5e-3;        // damping while the handle comes to rest [N s/mm]
constexpr double kWorkspace = 20;      // a handle that drifts farther is not free [mm]
constexpr double kGripDamping = 2e-3;  // of the lightest hand, docs/device.md [N s/mm]

}  // namespace

DeviceProbe::DeviceProbe(double period) : period_(period) {
  intervals_.reserve(1 << 18);
  moves_.reserve(1 << 18);
}

void DeviceProbe::watch(const device::DeviceState& state) noexcept {
  if (last_time_ >= 0 && intervals_.size() < intervals_.capacity()) intervals_.push_back(state.time - last_time_);
  const Eigen::Vector3d move = state.handle.position - last_;
  for (int k = 0; k < 3 && last_time_ >= 0; ++k)
    if (move[k] != 0 && moves_.size() < moves_.capacity()) {
      moves_.push_back(std::abs(move[k]));
      least_move_ = std::min(least_move_, moves_.back());
    }
  last_ = state.handle.position;
  last_time_ = state.time;
  const auto span = std::clamp<std::size_t>(static_cast<std::size_t>(std::lround(0.01 / period_)), 1, track_.size() - 1);
  track_[seen_++ % track_.size()] = last_;
  if (seen_ > span)
    fastest_ = std::max(fastest_, (last_ - track_[(seen_ - 1 - span) % track_.size()]).norm() / (static_cast<double>(span) * period_));
  hottest_ = std::max(hottest_, state.temperature);
}

void DeviceProbe::begin(Task task, const device::DeviceState& state) noexcept {
  task_ = task;
  begun_ = state.time;
  origin_ = state.handle.position;
  sample_ = 0;
  first_push_ = 0;
}

device::Rendered DeviceProbe::render(const device::DeviceState& state) noexcept {
  if (!state.handle.position.allFinite()) return {};
  if (last_time_ < 0) {
    begin(Task::Rest, state);
    home_ = state.handle.position;
  }
  watch(state);
  if ((last_ - home_).norm() > kWorkspace && task_ != Task::Done) {
    has_drifted_ = true;
    next_ = Task::Done;
    afterBrake(state);
  }
  const double spent = state.time - begun_;
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  switch (task_) {
    case Task::Rest:
      if (spent > kRestSeconds / 2) noise_ = std::max(noise_, (state.handle.position - origin_).cwiseAbs().maxCoeff());
      if (spent <= kRestSeconds / 2) origin_ = state.handle.position;
      if (spent > kRestSeconds) begin(Task::Push, state);
      break;
    case Task::Push:
      out = push(state, spent);
      break;
    case Task::Brake: {
      const auto back = static_cast<std::size_t>(std::lround(0.004 / period_)) + 1;
      const Eigen::Vector3d way = last_ - track_[(seen_ - 1 - std::min(back, seen_ - 1)) % track_.size()];
      out = -kBrake * way / (static_cast<double>(back) * period_);
      if (spent > kSettleSeconds) afterBrake(state);
      break;
    }
    case Task::Step:
      out = step(state, spent);
      break;
    case Task::Done:
      break;
  }
  if (const double size = out.norm(); size > kMostForce) out *= kMostForce / size;
  return {{out, Eigen::Vector3d::Zero()}, 0, false};
}

/// A force that rises slowly, until the handle moves. After friction is overcome, the way grows with the third power of
/// time: the handle goes 8 times as far in twice the time, which gives the force at which it began.
Eigen::Vector3d DeviceProbe::push(const device::DeviceState& state, double spent) noexcept {
  const double size = kPushRate * spent, moved = along(state.handle.position), first = std::max(kMoved, 3 * noise_);
  if (first_push_ == 0 && moved > first) first_push_ = size;
  if (moved <= 8 * first && size < kMostForce) return force(size);
  if (moved > 8 * first) friction_[static_cast<std::size_t>(axis_)][direction_] = std::max(0.0, 2 * first_push_ - size);
  const bool was_last = axis_ == 2 && direction_;
  begin(Task::Brake, state);
  if (direction_) axis_ = (axis_ + 1) % 3;
  direction_ = !direction_;
  next_ = was_last ? Task::Step : Task::Push;
  if (was_last && friction_[0][0] * friction_[0][1] == 0) next_ = Task::Done;  // nothing to step against
  return Eigen::Vector3d::Zero();
}

/// Of a handle with Coulomb friction to a force that exceeds it by an acceleration of 1 for the time `pulse`, and then
/// ends: the way at `time`. The ratio of the two accelerations follows from the friction alone, not from the mass.
double DeviceProbe::response(double time, double pulse) const noexcept {
  const double friction = (friction_[0][0] + friction_[0][1]) / 2;
  const double braking = friction / (kStepForce - (1 - kPreload) * friction);
  if (time <= 0) return 0;
  if (time < pulse) return time * time / 2;
  const double coasting = std::min(time - pulse, pulse / braking);
  return pulse * pulse / 2 + pulse * coasting - braking * coasting * coasting / 2;
}

std::size_t DeviceProbe::traceLength() const noexcept {
  return std::min(kSamples, static_cast<std::size_t>(std::lround(kTraceSeconds / period_)));
}

/// The preload; then the step of the force for some steps, and nothing. The length of the pulse grows until the handle
/// reaches the speed that it may have; from then on the trials count.
Eigen::Vector3d DeviceProbe::step(const device::DeviceState& state, double spent) noexcept {
  const double preload = kPreload * friction_[0][direction_];
  if (sample_ == 0 && spent < kSettleSeconds) {
    origin_ = state.handle.position;
    return force(preload);
  }
  const double x = along(state.handle.position);
  if (is_counting_) sum_[sample_] += x;
  if (++sample_ < traceLength()) return sample_ <= pulse_ ? force(preload + kStepForce) : Eigen::Vector3d::Zero();
  begin(Task::Brake, state);
  direction_ = !direction_;
  next_ = Task::Step;
  reached_ += x;
  ++trial_;
  if (is_counting_) {
    if (trial_ == kTrials) next_ = Task::Done;
  } else if (trial_ == kTrialsOfLength) {
    const double pulse = static_cast<double>(pulse_) * period_, length = static_cast<double>(traceLength()) * period_;
    const double speed = reached_ / kTrialsOfLength / response(length, pulse) * pulse;
    const std::size_t longer = pulse_ + std::max<std::size_t>(1, pulse_ / 8);
    const bool is_seen = reached_ > kTrialsOfLength * least_move_;  // below a count the speed would be a guess
    is_counting_ =
        (is_seen && speed * static_cast<double>(longer) / static_cast<double>(pulse_) > kMostSpeed) || 2 * longer > traceLength();
    if (!is_counting_) pulse_ = longer;
    trial_ = 0;
    reached_ = 0;
  }
  return Eigen::Vector3d::Zero();
}

void DeviceProbe::afterBrake(const device::DeviceState& state) noexcept {
  begin(next_, state);
  if (next_ == Task::Done) done_.store(true, std::memory_order_release);
}

double DeviceProbe::meanPeriod() const {
  return intervals_.empty() ? 0 : std::accumulate(intervals_.begin(), intervals_.end(), 0.0) / static_cast<double>(intervals_.size());
}

double DeviceProbe::jitter(double share) const {
  std::vector<double> off;
  for (const double interval : intervals_) off.push_back(std::abs(interval - period_));
  if (off.empty()) return 0;
  const auto nth = off.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(off.size() - 1));
  std::nth_element(off.begin(), nth, off.end());
  return *nth;
}

std::optional<double> DeviceProbe::count() const {
  if (moves_.empty()) return std::nullopt;
  const double least = *std::min_element(moves_.begin(), moves_.end());
  const auto is_multiple = [&](double move) { return std::abs(move / least - std::round(move / least)) < 0.01; };
  const auto multiples = std::count_if(moves_.begin(), moves_.end(), is_multiple);
  if (least < 1e-6 || static_cast<double>(multiples) < 0.95 * static_cast<double>(moves_.size())) return std::nullopt;
  double sum = 0, counts = 0;
  for (const double move : moves_)
    if (is_multiple(move)) sum += move, counts += std::round(move / least);
  return sum / counts;
}

std::array<std::optional<double>, 3> DeviceProbe::friction() const {
  std::array<std::optional<double>, 3> out;
  for (std::size_t k = 0; k < 3; ++k)  // a weight, or a spring of the cable, acts in one direction: the mean is free of it
    if (friction_[k][0] > 0 && friction_[k][1] > 0) out[k] = (friction_[k][0] + friction_[k][1]) / 2;
  return out;
}

/// The delay with which the expected motion fits the mean one best. The trials begin anywhere within a count of the
/// encoder, so that their mean is finer than a count.
std::optional<double> DeviceProbe::latency() const {
  if (trial_ < kTrials || !(reached_ > kMoved)) return std::nullopt;
  const double pulse = static_cast<double>(pulse_) * period_;
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (double delay = 0; delay < kTraceSeconds / 2; delay += kFineness) {
    double xy = 0, xx = 0, yy = 0;
    for (std::size_t k = 0; k < traceLength(); ++k) {
      const double x = response(static_cast<double>(k) * period_ - delay, pulse), y = sum_[k] / kTrials;
      xy += x * y, xx += x * x, yy += y * y;
    }
    const double error = yy - xy * xy / xx;
    if (error < least) least = error, best = delay;
  }
  return best;
}

nlohmann::ordered_json measureDevice(const PlaySettings& settings) {
  const std::unique_ptr<device::Device> device = openDeviceOf(settings);
  device::SafetySettings safety = safetyOf(settings);
  safety.max_force = kMostForce;
  DeviceProbe probe(safety.period);
  const device::EmergencyStop emergency_stop;
  device->start(probe, safety, settings.clock);
  while (!probe.isDone() && device->status().phase == device::Phase::Running) {
    if (settings.clock == device::Clock::Stepped)
      device->step();
    else
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  const device::DeviceStatus status = device->status();
  device->stop();
  const std::string& model = device->info().model;
  if (status.phase == device::Phase::Failed)
    throw device::DeviceError(status.fault, model + " failed while it was measured. Check its cable and power, then start again");
  const std::array<std::optional<double>, 3> friction = probe.friction();
  const std::optional<double> latency = probe.latency(), count = probe.count();
  if (probe.hasDrifted())
    throw device::DeviceError(device::DeviceFault::Refused,
                              model + ": the handle drifted by more than " + std::to_string(static_cast<int>(kWorkspace)) +
                                  " mm. Let go of it where it rests by itself, or carry its weight (--carried-weight)");
  if (!latency && !device::EmergencyStop::requested())
    throw device::DeviceError(device::DeviceFault::Refused,
                              model + ": the handle did not move by " + std::to_string(static_cast<int>(kMostForce)) +
                                  " N. Let go of it, in the middle of its workspace, hold no button, and see that its forces are on");
  const auto value = [](const std::optional<double>& number, double unit) {
    return number ? Json(std::round(*number * unit * 1e6) / 1e6) : Json(nullptr);
  };
  const double late_share = status.ticks > 0 ? static_cast<double>(status.late_ticks) / static_cast<double>(status.ticks) : 0;
  Json out = {{"schema", "spheretree.device_measures/1"},
              {"device", model},
              {"serial", device->info().serial},
              {"driver", device->info().driver},
              {"renders_torque", device->info().renders_torque},
              {"rate_hz", probe.meanPeriod() > 0 ? std::round(1e3 / probe.meanPeriod()) / 1e3 : 0},
              {"jitter_us",
               {{"median", value(probe.jitter(0.5), 1e6)}, {"p99", value(probe.jitter(0.99), 1e6)}, {"max", value(probe.jitter(1), 1e6)}}},
              {"late_steps", status.late_ticks},
              {"latency_ms", value(latency, 1e3)},
              {"encoder_count_mm", value(count, 1)},
              {"friction_n", {value(friction[0], 1), value(friction[1], 1), value(friction[2], 1)}},
              {"temperature", value(probe.hottest(), 1)},
              {"fastest_mm_s", value(probe.fastest(), 1)},
              {"end", latency ? "complete" : "interrupted"}};
  if (!latency) return out;
  // Stable for the lightest hand (Colgate and Schenkel), and quiet by friction against counts of the encoder (Abbott
  // and Okamura); half of that is proposed.
  double stiffness = 2 * kGripDamping / (safety.period + 2 * std::max(0.0, *latency));
  if (count && friction[0]) stiffness = std::min(stiffness, 2 * *friction[0] / *count);
  constexpr double kLateShare = 1e-3;
  out["proposed"] = {{"rate_hz", late_share <= kLateShare ? settings.rate : std::max(500.0, settings.rate / 2)},
                     {"stiffness_n_per_mm", std::round(500 * stiffness) / 1000}};
  return out;
}

}  // namespace spheretree::player
