// SPDX-License-Identifier: Apache-2.0
// A haptic device: where the hand holds the tool in, the wrench that the hand feels out, 1000 times a second.
// Units: mm, N, N mm, s, rad. Device frame: +x right, +y up, +z towards the user. What every device has in common is
// here, the safety rules among it: no wrench reaches a device around them. Each device is opened by a function of its
// own: simulated_device.h, replay_device.h, phantom_device.h.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>

#include "spheretree/core/rigid.h"
#include "spheretree/device/safety.h"

namespace spheretree::device {

/// What an open device says of itself.
struct DeviceInfo {
  std::string model, serial, driver;                           // driver: name and version of what drives it; empty where it does not say
  double max_force = std::numeric_limits<double>::infinity();  // of the vector, for a moment [N]
  double continuous_force = std::numeric_limits<double>::infinity();                                // for ever [N]
  Eigen::Vector3d max_torque = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());  // each, handle axes [N mm]
  Eigen::Vector3d continuous_torque = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  bool renders_torque = true;  // false: 6 degrees of freedom in, 3 out
  bool can_step = true;        // takes Clock::Stepped
  int delay = 0;               // whole servo steps from a pose to the wrench that answers it
};

enum class DeviceFault : std::uint8_t {
  None,
  LibraryMissing,  // the vendor's library cannot be loaded
  SymbolMissing,   // it lacks a function: another version
  NotFound,        // no such device, not plugged in, or no right to open it
  NotCalibrated,   // needs the user's hand first
  Refused,         // a setting that this device does not take
  Communication,   // lost while running
};

/// Opening or starting failed. The message says what, where and what to do next.
struct DeviceError : std::runtime_error {
  DeviceError(DeviceFault why, const std::string& message) : std::runtime_error(message), fault(why) {}
  DeviceFault fault;
};

/// What computes the wrench. Called from the device's thread (Clock::Real) or from step().
class Renderer {
 public:
  /// Must return well within kServoPeriod; no allocation, lock or I/O. The wrench acts on the hand, about
  /// state.handle.position, device axes.
  virtual Rendered render(const DeviceState& state) noexcept = 0;

 protected:
  ~Renderer() = default;
};

enum class Clock : std::uint8_t {
  Real,     // the device calls the renderer every kServoPeriod, in a thread of its own
  Stepped,  // each step() is one servo step: as fast as the machine can, and the same bytes every time
};

enum class Phase : std::uint8_t {
  Stopped,  // not started, or stop() was called
  Running,
  Ended,   // its input is over
  Failed,  // status().fault says why; never restarts by itself
  Halted,  // by the emergency stop
};

/// A snapshot, to be taken from any thread.
struct DeviceStatus {
  Phase phase = Phase::Stopped;
  DeviceFault fault = DeviceFault::None;
  std::int32_t vendor_code = 0;     // of the fault, or of the last one that was recovered from, in the vendor's numbers
  std::uint64_t ticks = 0;          // servo steps since start()
  std::uint64_t late_ticks = 0;     // of them, begun more than one period late
  std::uint32_t safety = 0;         // SafetyEvent bits of the last step
  std::uint32_t safety_so_far = 0;  // of all steps
};

class Device {
 public:
  virtual ~Device() = default;  // every device sends zero and stops in its own destructor
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const noexcept { return info_; }

  /// Begins servo steps. `renderer` must live until stop() has returned. The limits are narrowed to those of the
  /// device.
  /// @throws DeviceError if the clock is not for this device, it runs already, a setting is out of range, or it does
  /// not start.
  void start(Renderer& renderer, const SafetySettings& safety, Clock clock);

  /// One servo step; Clock::Stepped only. False, and nothing done, once the phase is no longer Running.
  bool step() noexcept;

  /// Sends zero, stops, waits for the device's thread. Any number of times. Not from render().
  void stop() noexcept;

  /// Forces come back after a stale model or a failing renderer had switched them off: by guard and ramp as at the
  /// start.
  void rearm() noexcept { rearm_.store(true, std::memory_order_relaxed); }

  DeviceStatus status() const noexcept;

 protected:
  Device() = default;
  DeviceInfo info_;

  /// For a device's own servo step: asks the renderer, applies the safety rules, keeps the status. What it returns is
  /// to be sent. Sets state.tick and state.time itself.
  Wrench tick(DeviceState state) noexcept;
  void finish(Phase phase, DeviceFault fault = DeviceFault::None, std::int32_t vendor_code = 0) noexcept;
  void note(std::int32_t vendor_code) noexcept { vendor_code_.store(vendor_code, std::memory_order_relaxed); }

 private:
  /// @throws DeviceError
  virtual void begin(Clock) {}
  /// One servo step of a device without a clock of its own: read, tick(), act. False: the input is over.
  virtual bool advance() noexcept = 0;
  /// Zero wrench, hardware stopped; nothing calls tick() after it.
  virtual void end() noexcept {}
  /// True if begin() makes something call tick() every kServoPeriod: then advance() is never called.
  virtual bool hasOwnClock() const noexcept { return false; }

  bool advanceOnce() noexcept;
  void runRealTime() noexcept;

  Renderer* renderer_ = nullptr;
  Safety safety_;
  Clock clock_ = Clock::Stepped;
  std::int64_t started_ns_ = 0;
  double last_time_ = 0;  // of a servo step [s]
  std::thread thread_;
  bool started_ = false;
  std::atomic<bool> stop_{false}, rearm_{false};
  std::atomic<Phase> phase_{Phase::Stopped};
  std::atomic<DeviceFault> fault_{DeviceFault::None};
  std::atomic<std::int32_t> vendor_code_{0};
  std::atomic<std::uint64_t> ticks_{0}, late_ticks_{0};
  std::atomic<std::uint32_t> safety_bits_{0}, safety_so_far_{0};
};

}  // namespace spheretree::device
