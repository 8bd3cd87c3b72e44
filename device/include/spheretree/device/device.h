// SPDX-License-Identifier: Apache-2.0
// A haptic device: it reports where the hand holds the tool and renders a wrench to the hand, 1000 times a
// second, or at the rate of SafetySettings::period.
// Units: mm, N, N mm, s, rad. Device frame: +x right, +y up, +z towards the user. This header has what all devices
// share, including the safety rules: no wrench reaches a device without passing them. Each kind of device has its own
// constructor: simulated_device.h, replay_device.h, phantom_device.h.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <thread>

#include "spheretree/core/rigid.h"
#include "spheretree/device/clutch.h"
#include "spheretree/device/safety.h"

namespace spheretree::device {

/// The properties that an open device reports.
struct DeviceInfo {
  std::string model, serial, driver;                                  // driver: name and version of the driver; empty if unknown
  double max_force = std::numeric_limits<double>::infinity();         // of the vector, for a short time [N]
  double continuous_force = std::numeric_limits<double>::infinity();  // sustainable without a time limit [N]
  Eigen::Vector3d max_torque = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());  // each component, handle axes [N mm]
  Eigen::Vector3d continuous_torque = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  bool renders_torque = true;  // false: 6 degrees of freedom in, 3 out
  bool can_step = true;        // supports Clock::Stepped
  int delay = 0;               // whole servo steps from a pose to the wrench that responds to it
};

enum class DeviceFault : std::uint8_t {
  None,
  LibraryMissing,  // the vendor's library cannot be loaded
  SymbolMissing,   // it lacks a function: probably another version
  NotFound,        // no such device, not plugged in, or no permission to open it
  NotCalibrated,   // needs a calibration by the user first
  Refused,         // a setting that this device does not support
  Communication,   // connection lost while running
};

/// Opening or starting failed. The message says what failed, where, and what to do next.
struct DeviceError : std::runtime_error {
  DeviceError(DeviceFault why, const std::string& message) : std::runtime_error(message), fault(why) {}
  DeviceFault fault;
};

/// Computes the wrench. Called from the device's thread (Clock::Real) or from step().
class Renderer {
 public:
  /// Must return well within a period, without allocation, lock or I/O. The wrench acts on the hand, about
  /// state.handle.position, in device axes.
  virtual Rendered render(const DeviceState& state) noexcept = 0;

 protected:
  ~Renderer() = default;
};

enum class Clock : std::uint8_t {
  Real,     // the device calls the renderer every SafetySettings::period, in a thread of its own
  Stepped,  // each call of step() is one servo step: as fast as the machine can, with the same bytes every time
};

enum class Phase : std::uint8_t {
  Stopped,  // not started, or stop() was called
  Running,
  Ended,   // the end of the input was reached
  Failed,  // status().fault says why; the device never restarts by itself
  Halted,  // by the emergency stop
};

/// A snapshot of the state; any thread may take it.
struct DeviceStatus {
  Phase phase = Phase::Stopped;
  DeviceFault fault = DeviceFault::None;
  std::int32_t vendor_code = 0;     // the vendor's code of the fault, or of the last fault from which the device recovered
  std::uint64_t ticks = 0;          // servo steps since start()
  std::uint64_t late_ticks = 0;     // servo steps that began more than one period late
  std::uint32_t safety = 0;         // SafetyEvent bits of the last step
  std::uint32_t safety_so_far = 0;  // of all steps
};

class Device {
 public:
  virtual ~Device() = default;  // every derived device sends zero and stops in its own destructor
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  const DeviceInfo& info() const noexcept { return info_; }

  /// Starts the servo steps. `renderer` must live until stop() has returned. The limits are reduced to those of the
  /// device.
  /// @throws DeviceError if the device does not support the clock, already runs or does not start, or if a setting is
  /// out of range.
  void start(Renderer& renderer, const SafetySettings& safety, Clock clock);

  /// Lets one period pass, with its servo step; Clock::Stepped only. Returns false, and does nothing, if the phase is
  /// not Running.
  bool step() noexcept;

  /// How often servo steps are taken, for a run that is watched: in one of `periods` periods; 1: in each, as after
  /// start(); 0: in none, a pause. Steps stay the same: DeviceState::time leaves out the periods between them. A device
  /// that cannot step, whose hand does not slow down, takes 1 and 0 only. Its pause is a zero wrench without the
  /// renderer, after which forces return as after a release. Returns false, and changes nothing, otherwise.
  bool setPace(std::uint32_t periods) noexcept;
  /// One servo step more during a pause. Returns false for a device that cannot step.
  bool stepOnce() noexcept;
  /// The next servo step is the first one again, also in a pause: the input, the time and the safety rules begin anew,
  /// and the renderer sees DeviceState::restarted. status() keeps counting. Returns false for a device that
  /// cannot step: nobody can put its handle back.
  bool restart() noexcept;

  /// Sends zero, stops, and waits for the device's thread. May be called repeatedly, but not from render().
  void stop() noexcept;

  /// Enables forces again after a stale model or a failing renderer switched them off. They return through the start
  /// guard and the ramp, as at the start.
  void rearm() noexcept { rearm_.store(true, std::memory_order_relaxed); }

  DeviceStatus status() const noexcept;

 protected:
  Device() = default;
  DeviceInfo info_;

  /// For a device's own servo step: calls the renderer, applies the safety rules and updates the status. The device
  /// must send the returned wrench. Sets state.tick and state.time itself.
  Wrench tick(DeviceState state) noexcept;
  void finish(Phase phase, DeviceFault fault = DeviceFault::None, std::int32_t vendor_code = 0) noexcept;
  double period() const noexcept { return safety_settings_.period; }  // of the servo steps, in begin() and later [s]
  void note(std::int32_t vendor_code) noexcept { vendor_code_.store(vendor_code, std::memory_order_relaxed); }

 private:
  /// @throws DeviceError
  virtual void begin(Clock) {}
  /// One servo step of a device without a clock of its own: read, tick(), act. Returns false at the end of the input.
  virtual bool advance() noexcept = 0;
  /// Back to the beginning of the input, for restart().
  virtual void rewind() noexcept {}
  /// Sets a zero wrench and stops the hardware; tick() is not called afterwards.
  virtual void end() noexcept {}
  /// True if begin() starts a clock that calls tick() every period; advance() is then never called.
  virtual bool hasOwnClock() const noexcept { return false; }

  bool isDue() noexcept;
  bool advanceOnce() noexcept;
  void runRealTime() noexcept;

  Renderer* renderer_ = nullptr;
  SafetySettings safety_settings_;
  Safety safety_;
  Clutch clutch_;
  Clock clock_ = Clock::Stepped;
  std::int64_t period_ns_ = 0, started_ns_ = 0;
  double last_time_ = 0;          // of a servo step [s]
  std::uint64_t first_tick_ = 0;  // of status().ticks, since start() or restart()
  std::uint32_t waited_ = 0;      // periods since the last servo step
  bool restarted_ = false;
  std::thread thread_;
  bool started_ = false;
  std::atomic<bool> stop_{false}, rearm_{false}, restart_{false};
  std::atomic<std::uint32_t> pace_{1}, single_steps_{0};
  std::atomic<Phase> phase_{Phase::Stopped};
  std::atomic<DeviceFault> fault_{DeviceFault::None};
  std::atomic<std::int32_t> vendor_code_{0};
  std::atomic<std::uint64_t> ticks_{0}, late_ticks_{0};
  std::atomic<std::uint32_t> safety_bits_{0}, safety_so_far_{0};
};

}  // namespace spheretree::device
