// SPDX-License-Identifier: Apache-2.0
// The safety rules between the computed wrench and the wrench that a device receives. Every rule is documented and
// tested: docs/device.md
#pragma once

#include <cstdint>
#include <string>

#include "spheretree/core/rigid.h"
#include "spheretree/device/passivity.h"

namespace spheretree::device {

/// The state that a device reports at the beginning of a servo step.
struct DeviceState {
  std::uint64_t tick = 0;     // counts from 0 at start
  double time = 0;            // since start [s]
  Configuration handle;       // position at which the wrench acts, and orientation of the handle; device frame
  std::uint32_t buttons = 0;  // bit n: button n is held
  bool released = false;      // nobody holds it (safety switch), or the device switched its forces off for a moment
  double age = 0;             // time since the device measured this pose [s]; 0: it is of this step
  double temperature = 0;     // of the hottest motor, 0..1; 0 if the device does not report it
  bool failed = false;        // communication, timer or hardware fault: this is the last step of the run
  Wrench added;               // added by passivity control to the wrench of the step before; zero if it was inactive
  double debt = 0;            // energy that passivity control has yet to remove; negative: none [mJ]
  bool restarted = false;     // the first step after Device::restart(): nothing of the steps before counts
};

/// The answer of a renderer.
struct Rendered {
  Wrench wrench;         // on the hand, about DeviceState::handle.position, device axes [N, N mm]
  double model_age = 0;  // time since the contacts that it uses were computed [s]; 0 if they are of this step
  bool failed = false;   // no valid answer: the wrench must not be used
};

struct SafetySettings {
  double period = kServoPeriod;                     // from one servo step to the next [s]; [0.000125, 0.002]
  double max_force = 8;                             // of the vector [N]
  Eigen::Vector3d max_torque{188, 188, 48};         // of each component in handle axes, z along the handle [N mm]
  double continuous_force = 3;                      // limit while the motors are warm [N]
  Eigen::Vector3d continuous_torque{188, 188, 48};  // [N mm]
  double force_slew = 0.5, torque_slew = 12;        // largest increase in 1 ms, except at the beginning of a contact [N, N mm]
  double contact_start = 0.01;  // after a rest of at least this duration, a contact may increase faster for this duration [s]; [0, 1]
  bool start_guard = true;      // start as after a release: zero until the requested wrench is nearly zero, then the ramp
  double guard_force = 0.2, guard_torque = 5;             // limits of nearly zero [N, N mm], for more than 3 ms
  double ramp = 2;                                        // duration from zero to the full wrench [s]; [0.001, 60]
  double ramp_force_slew = 0.05, ramp_torque_slew = 1.2;  // as force_slew and torque_slew, during the ramp
  double stale_after = 0.02;                              // contacts or poses older than this fade [s]
  double stale_fade = 0.1;                                // duration of that fade [s]
  double off_after = 0.2;                                 // contacts or poses older than this switch the forces off until rearm() [s]
  double hold = 0.005;  // for this time the last valid wrench replaces a failed one; then it fades like a stale one [s]
  double fade_speed = 1000, fade_force = 1;  // if faster and stronger than these, the wrench fades [mm/s, N]
  double fade_time = 0.05;                   // duration of that fade [s]; [0.001, 60]
  double pose_jump = 10;                     // a larger motion in 1 ms is a new calibration, not a hand [mm]
  double warm = 0.7, cool = 0.5;             // temperatures: limits shrink above `warm` and recover below `cool`; 0 < cool <= warm
  double thermal_rate = 1e-3;                // relative change of the limits in 1 ms; (0, 0.5]
  std::uint32_t release_buttons = 1;         // bits of buttons; zero while one of them is held
  std::uint32_t clutch_buttons = 0;  // as release_buttons; the renderer's position also stands still, and goes on from there afterwards
  double carried_weight = 0;         // of the handle, which the motors carry upwards (+y) [N]; [0, 5]
  bool passivity_control = false;    // remove the energy that sampling and delay add: passivity.h
  double passivity_damping = 0.01;   // largest damping for that [N s/mm]
  int delay = 0;                     // steps from a pose to its wrench, 0..kMaxDelay; set by the device
};                                   // Members without a range above: (0, 1e6]

/// Bits: the rules that took effect in a step.
enum SafetyEvent : std::uint32_t {
  kForceClamped = 1,
  kTorqueClamped = 2,
  kSlewLimited = 4,
  kStartGuard = 8,            // waits for a nearly zero wrench
  kRamp = 16,                 // the wrench is scaled down until the ramp ends
  kStaleModel = 32,           // the contacts or the pose are old, or the servo loop was late
  kForcesOff = 64,            // until rearm()
  kReleased = 128,            // a release button is held, or nobody holds the handle
  kTooFast = 256,             // fast and strong at the same time
  kWarmMotors = 512,          // limits are below the configured ones
  kRendererFailed = 1024,     // no valid wrench: the last valid one was held, then faded
  kBadPose = 2048,            // not finite, or jumped
  kDeviceFailed = 4096,       // zero for the rest of this run
  kEmergencyStop = 8192,      // zero for the rest of this run
  kPassivityControl = 16384,  // damping was added
};

/// Returns "" if all settings are in range, else a sentence that names the setting, its value and its range.
std::string findFault(const SafetySettings& settings);

class Safety {
 public:
  Safety() : Safety(SafetySettings()) {}
  /// `settings` must pass findFault().
  explicit Safety(const SafetySettings& settings) noexcept;

  /// The wrench to send in this step. Always finite, and never beyond max_force and max_torque, whatever the input. No
  /// allocation.
  Wrench limit(const DeviceState& state, const Rendered& rendered) noexcept;

  std::uint32_t events() const noexcept { return events_; }  // SafetyEvent bits of the last limit()
  const PassivityControl& passivity() const noexcept { return passivity_; }
  void rearm() noexcept;                             // ends kForcesOff; start guard and ramp follow
  void emergencyStop() noexcept { halted_ = true; }  // zero from now on

 private:
  bool mayRender(const DeviceState& state, double elapsed) noexcept;
  double freshness(double pose_age, const Rendered& rendered, double elapsed) noexcept;
  bool guardPassed(const Wrench& wrench) noexcept;
  void moveGain(double freshness, double force) noexcept;
  void followTemperature(double temperature) noexcept;
  void restart() noexcept;
  Wrench clamped(const Wrench& wrench, const Quaternion& handle, bool report) noexcept;
  Wrench controlled(const Configuration& handle, const Wrench& wrench) noexcept;
  Wrench slewed(const Wrench& wrench) noexcept;
  void followContact(double elapsed) noexcept;

  SafetySettings settings_;
  double in_ms_;         // period in milliseconds: rates per millisecond times this are rates per step
  double thermal_step_;  // factor of the limits in one step
  std::uint32_t events_ = 0;
  bool halted_ = false, device_failed_ = false, off_ = false, guarded_, warm_ = false;
  int calm_steps_ = 0;    // consecutive steps with a nearly zero wrench
  double gain_;           // of the ramp, 0..1
  double thermal_ = 1;    // limits are this share of the configured ones, but not below the continuous ones
  double failing_ = 0;    // time without a valid wrench [s]
  double contact_ = 0;    // time since a nonzero wrench was first sent [s]
  double rest_ = 1;       // time that only zero was sent before that [s]
  bool quick_ = false;    // the contact begins, and its wrench may increase faster
  double last_time_ = 0;  // [s]
  double speed_ = 0;      // of the handle [mm/s]
  bool has_position_ = false;
  Eigen::Vector3d last_position_ = Eigen::Vector3d::Zero();
  Wrench valid_;  // the last valid wrench of the renderer
  Wrench sent_;
  PassivityControl passivity_;
};

}  // namespace spheretree::device
