// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/device.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "spheretree/device/emergency_stop.h"
#include "system/system_calls.h"

namespace spheretree::device {
namespace {

std::int64_t nowNs() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

SafetySettings narrowed(SafetySettings settings, const DeviceInfo& info) {
  settings.max_force = std::min(settings.max_force, info.max_force);
  settings.max_torque = settings.max_torque.cwiseMin(info.max_torque);
  settings.continuous_force = std::min(settings.continuous_force, info.continuous_force);
  settings.continuous_torque = settings.continuous_torque.cwiseMin(info.continuous_torque);
  settings.delay = info.delay;
  return settings;
}

}  // namespace

void Device::start(Renderer& renderer, const SafetySettings& safety, Clock clock) {
  if (started_) throw DeviceError(DeviceFault::Refused, info_.model + " runs already: stop it first");
  if (clock == Clock::Stepped && !info_.can_step)
    throw DeviceError(DeviceFault::Refused, info_.model + " has a clock of its own and cannot be stepped: use the real clock");
  if (const std::string fault = findFault(safety); !fault.empty()) throw DeviceError(DeviceFault::Refused, "safety settings: " + fault);
  renderer_ = &renderer;
  safety_settings_ = narrowed(safety, info_);
  safety_ = Safety(safety_settings_);
  clutch_ = Clutch(safety_settings_.clutch_buttons);
  period_ns_ = std::llround(1e9 * safety_settings_.period);
  clock_ = clock;
  stop_ = rearm_ = restart_ = restarted_ = false;
  pace_ = 1;
  single_steps_ = waited_ = 0;
  first_tick_ = 0;
  fault_ = DeviceFault::None;
  vendor_code_ = 0;
  ticks_ = late_ticks_ = 0;
  safety_bits_ = safety_so_far_ = 0;
  phase_ = Phase::Running;
  started_ns_ = nowNs();
  last_time_ = 0;
  try {
    begin(clock);
    if (clock == Clock::Real && !hasOwnClock()) thread_ = std::thread([this] { runRealTime(); });
  } catch (...) {
    phase_ = Phase::Stopped;
    throw;
  }
  started_ = true;
}

bool Device::step() noexcept {
  if (!started_ || clock_ != Clock::Stepped) return false;
  return isDue() ? advanceOnce() : phase_.load(std::memory_order_relaxed) == Phase::Running;
}

bool Device::setPace(std::uint32_t periods) noexcept {
  if (!info_.can_step && periods > 1) return false;
  if (periods > 0) single_steps_ = 0;
  pace_ = periods;
  return true;
}

bool Device::stepOnce() noexcept {
  if (!info_.can_step) return false;
  ++single_steps_;
  return true;
}

bool Device::restart() noexcept {
  if (!info_.can_step) return false;
  restart_ = true;
  return true;
}

/// Whether the period that begins now has a servo step.
bool Device::isDue() noexcept {
  const std::uint32_t pace = pace_.load(std::memory_order_relaxed);
  ++waited_;
  if (!info_.can_step) return true;  // the motors need a command in each period
  // An emergency stop must reach Phase::Halted, which a step does.
  if ((pace > 0 && waited_ >= pace) || restart_.load(std::memory_order_relaxed) || EmergencyStop::requested()) return true;
  std::uint32_t singles = single_steps_.load(std::memory_order_relaxed);
  while (singles > 0)
    if (single_steps_.compare_exchange_weak(singles, singles - 1)) return true;
  return false;
}

void Device::stop() noexcept {
  if (!started_) return;
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  end();
  started_ = false;
  finish(Phase::Stopped);
}

DeviceStatus Device::status() const noexcept {
  return {.phase = phase_.load(),
          .fault = fault_.load(),
          .vendor_code = vendor_code_.load(),
          .ticks = ticks_.load(),
          .late_ticks = late_ticks_.load(),
          .safety = safety_bits_.load(),
          .safety_so_far = safety_so_far_.load()};
}

Wrench Device::tick(DeviceState state) noexcept {
  const bool is_paused = pace_.load(std::memory_order_relaxed) == 0 && !info_.can_step;
  state.tick = ticks_.load(std::memory_order_relaxed) - first_tick_;
  state.restarted = std::exchange(restarted_, false);
  state.time = clock_ == Clock::Real ? static_cast<double>(nowNs() - started_ns_) * 1e-9 : static_cast<double>(state.tick) * period();
  if (state.time - last_time_ > 2 * period()) late_ticks_.fetch_add(1, std::memory_order_relaxed);
  last_time_ = state.time;
  if (rearm_.exchange(false, std::memory_order_relaxed)) safety_.rearm();
  if (EmergencyStop::requested()) safety_.emergencyStop();
  state.added = safety_.passivity().added();
  state.debt = safety_.passivity().debt();
  if (is_paused) state.released = true;  // forces then return gently
  DeviceState seen = state;
  seen.handle.position = clutch_.follow(state.handle.position, state.buttons);
  Wrench wrench = safety_.limit(state, is_paused ? Rendered() : renderer_->render(seen));
  if (is_paused)
    wrench = {};
  else
    ticks_.fetch_add(1, std::memory_order_relaxed);
  safety_bits_.store(safety_.events(), std::memory_order_relaxed);
  safety_so_far_.fetch_or(safety_.events(), std::memory_order_relaxed);
  if (safety_.events() & kEmergencyStop) finish(Phase::Halted);
  return wrench;
}

void Device::finish(Phase phase, DeviceFault fault, std::int32_t vendor_code) noexcept {
  Phase running = Phase::Running;  // the first reason is kept
  if (phase_.compare_exchange_strong(running, phase) && fault != DeviceFault::None) {
    vendor_code_ = vendor_code;
    fault_ = fault;
  }
}

bool Device::advanceOnce() noexcept {
  if (phase_.load(std::memory_order_relaxed) != Phase::Running) return false;
  if (restart_.exchange(false)) {
    rewind();
    safety_ = Safety(safety_settings_);
    clutch_ = Clutch(safety_settings_.clutch_buttons);
    first_tick_ = ticks_.load(std::memory_order_relaxed);
    started_ns_ = nowNs();
    last_time_ = 0;
    restarted_ = true;
  } else if (waited_ > 1 && clock_ == Clock::Real) {  // the time of the periods without a step does not count
    started_ns_ = nowNs() - std::llround(1e9 * last_time_) - period_ns_;
  }
  waited_ = 0;
  if (advance()) return true;
  finish(Phase::Ended);
  return false;
}

void Device::runRealTime() noexcept {
  std::int64_t due = nowNs();
  while (!stop_.load(std::memory_order_relaxed) && (!isDue() || advanceOnce())) {
    due += period_ns_;
    const std::int64_t late = nowNs() - due;
    if (late < 0) {
      sleepUntil(due);
    } else if (late > period_ns_) {  // whole periods are skipped, never caught up in a burst
      due += late - late % period_ns_;
    }
  }
}

}  // namespace spheretree::device
