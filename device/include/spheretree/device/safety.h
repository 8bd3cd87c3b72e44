// SPDX-License-Identifier: Apache-2.0
// Between the wrench that was computed and the wrench that a device gets. Every rule is stated and tested:
// docs/device.md
#pragma once

#include <cstdint>
#include <string>

#include "spheretree/core/rigid.h"
#include "spheretree/device/passivity.h"

namespace spheretree::device {

inline constexpr double kServoPeriod = 1e-3;  // [s]

/// What a device reports at the begin of a servo step.
struct DeviceState {
  std::uint64_t tick = 0;     // counts from 0 at start
  double time = 0;            // since start [s]
  Configuration handle;       // where the wrench acts, and how the handle is turned; device frame
  std::uint32_t buttons = 0;  // bit n: button n is held
  bool released = false;      // no hand holds it (safety switch), or the device took its forces off for a moment
  double temperature = 0;     // of the hottest motor, 0..1; 0 where the device does not say
  bool failed = false;        // communication, timer or hardware fault: the last step of this run
  Wrench added;               // by passivity control to the wrench of the step before; zero: it did nothing
  double debt = 0;            // energy that it has still to take back then; below 0: none [mJ]
};

/// What a renderer answers.
struct Rendered {
  Wrench wrench;         // on the hand, about DeviceState::handle.position, device axes [N, N mm]
  double model_age = 0;  // since the contacts behind it were computed [s]; 0 if they are of this step
  bool failed = false;   // no valid answer: the wrench is not to be used
};

struct SafetySettings {
  double max_force = 8;                                   // of the vector [N]
  Eigen::Vector3d max_torque{188, 188, 48};               // of each component in handle axes, z along the handle [N mm]
  double continuous_force = 3;                            // what warm motors are brought back to [N]
  Eigen::Vector3d continuous_torque{188, 188, 48};        // [N mm]
  double force_slew = 0.5, torque_slew = 12;              // largest rise in one step, but while a contact begins [N, N mm]
  double contact_start = 0.01;                            // a contact after as long a rest may rise faster for this long [s]; [0, 1]
  bool start_guard = true;                                // begin as after a release: zero until nearly nothing is asked, then the ramp
  double guard_force = 0.2, guard_torque = 5;             // nearly nothing [N, N mm]; for more than 3 steps
  double ramp = 2;                                        // from nothing to all [s]; [0.001, 60]
  double ramp_force_slew = 0.05, ramp_torque_slew = 1.2;  // as force_slew, during the ramp
  double stale_after = 0.02;                              // older contacts fade [s]
  double stale_fade = 0.1;                                // in this time [s]
  double off_after = 0.2;                                 // forces off: rearm() [s]
  double hold = 0.005;                                    // the last good wrench stands in for a failed one, then fades as a stale one [s]
  double fade_speed = 1000, fade_force = 1;               // faster and stronger than this fades [mm/s, N]
  double fade_time = 0.05;                                // in this time [s]; [0.001, 60]
  double pose_jump = 10;                                  // in one step: not a hand but a new calibration [mm]
  double warm = 0.7, cool = 0.5;                          // temperature: limits shrink above, grow back below; 0 < cool <= warm
  double thermal_rate = 1e-3;                             // by which share in one step; (0, 0.5]
  std::uint32_t release_buttons = 1;                      // while one of these is held: zero
  bool passivity_control = false;                         // take back what sampling and delay give: passivity.h
  double passivity_damping = 0.01;                        // by no more damping than this [N s/mm]
  int delay = 0;                                          // steps from a pose to its wrench, 0..kMostDelay; the device says it
};                                                        // what has no range above: (0, 1e6]

/// Bits: which rules were at work in a step.
enum SafetyEvent : std::uint32_t {
  kForceClamped = 1,
  kTorqueClamped = 2,
  kSlewLimited = 4,
  kStartGuard = 8,            // waiting for a nearly zero wrench
  kRamp = 16,                 // coming back
  kStaleModel = 32,           // the contacts are old, or the servo was late
  kForcesOff = 64,            // until rearm()
  kReleased = 128,            // button, or no hand
  kTooFast = 256,             // fast and strong
  kWarmMotors = 512,          // limits are below the set ones
  kRendererFailed = 1024,     // no valid wrench: the last one held, then faded
  kBadPose = 2048,            // not finite, or jumped
  kDeviceFailed = 4096,       // zero for the rest of this run
  kEmergencyStop = 8192,      // zero for the rest of this run
  kPassivityControl = 16384,  // damping was added
};

/// Empty if all settings are in range, else a sentence that names the setting, its value and its range.
std::string findFault(const SafetySettings& settings);

class Safety {
 public:
  Safety() : Safety(SafetySettings()) {}
  /// `settings` as findFault() accepts them.
  explicit Safety(const SafetySettings& settings) noexcept;

  /// The wrench to send in this step. Never beyond max_force and max_torque, always finite, whatever comes in. No
  /// allocation.
  Wrench limit(const DeviceState& state, const Rendered& rendered) noexcept;

  std::uint32_t events() const noexcept { return events_; }  // SafetyEvent bits of the last limit()
  const PassivityControl& passivity() const noexcept { return passivity_; }
  void rearm() noexcept;                             // ends kForcesOff: guard and ramp
  void emergencyStop() noexcept { halted_ = true; }  // zero from now on

 private:
  bool mayRender(const DeviceState& state, double elapsed) noexcept;
  double freshness(const Rendered& rendered, double elapsed) noexcept;
  bool guardPassed(const Wrench& wrench) noexcept;
  void moveGain(double freshness, double force) noexcept;
  void followTemperature(double temperature) noexcept;
  void restart() noexcept;
  Wrench clamped(const Wrench& wrench, const Quaternion& handle, bool report) noexcept;
  Wrench controlled(const Configuration& handle, const Wrench& wrench) noexcept;
  Wrench slewed(const Wrench& wrench) noexcept;
  void followContact(double elapsed) noexcept;

  SafetySettings settings_;
  std::uint32_t events_ = 0;
  bool halted_ = false, device_failed_ = false, off_ = false, guarded_, warm_ = false;
  int calm_steps_ = 0;    // in a row with a nearly zero wrench
  double gain_;           // of the ramp, 0..1
  double thermal_ = 1;    // limits are this much of the set ones, or the continuous ones if those are larger
  double failing_ = 0;    // how long there was no valid wrench [s]
  double contact_ = 0;    // how long something was sent [s]
  double rest_ = 1;       // how long nothing was sent before that [s]
  bool quick_ = false;    // the contact begins, and may rise faster
  double last_time_ = 0;  // [s]
  double speed_ = 0;      // of the handle [mm/s]
  bool has_position_ = false;
  Eigen::Vector3d last_position_ = Eigen::Vector3d::Zero();
  Wrench valid_;  // the last that the renderer stood by
  Wrench sent_;
  PassivityControl passivity_;
};

}  // namespace spheretree::device
