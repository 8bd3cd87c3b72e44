// SPDX-License-Identifier: Apache-2.0
// A large Phantom and the hand that holds it, in closed loop: mass, friction, encoders, sample and hold, delay,
// saturation, heat. It becomes unstable under the conditions that theory and measurements state for the real device:
// docs/device.md
// Model of friction: Coulomb and viscous; J. E. Colgate and G. Schenkel, J. Robotic Systems 14(1), 1997; J. J. Abbott
// and A. M. Okamura, IEEE Trans. Robotics 21(5), 2005.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "spheretree/device/device.h"

namespace spheretree::device {

/// A hand: a mass that is rigidly attached to the handle, and a spring with damper to the pose that the hand intends.
struct Hand {
  const char* name;
  double mass;                                                             // [kg]; >= 0, as all members
  double damping;                                                          // [N s/m]
  double stiffness;                                                        // [N/m]
  double inertia = 2e-5, angular_damping = 2e-3, angular_stiffness = 0.5;  // [kg m^2, N m s/rad, N m/rad]
};

/// The hands: arm (Sci. Rep. 5:18004, 2015), fine, light, firm (assumed), teleoperator (Y. Yokokohji, T. Yoshikawa,
/// IEEE Trans. Robotics Autom. 10(5), 1994), released (a string that barely holds the handle).
std::span<const Hand> hands() noexcept;
std::optional<Hand> findHand(std::string_view name) noexcept;

/// The pose that the hand intends at a time since start [s]. It is called once each servo step, and must be defined and
/// finite for all t >= 0.
using IntendedPath = std::function<Configuration(double)>;

struct SimulatedSettings {
  double mass = 0.159, inertia = 1e-4;                 // of the handle, as the hand feels it [kg, kg m^2]; >= 1e-3, >= 1e-7
  double viscous = 0.1, viscous_rotation = 2e-4;       // [N s/m, N m s/rad]; 0..100, 0..1
  double coulomb = 0.2, coulomb_rotation = 2;          // along or about each axis [N, N mm]; >= 0
  double position_step = 0.02;                         // resolution of the encoders [mm]; 0: exact
  Eigen::Vector3d angle_step{4.0e-5, 4.0e-5, 1.4e-4};  // resolution about the handle's axes [rad]; 0: exact
  int delay = 0;                                       // whole servo steps from a pose to its wrench; 0..7
  double max_force = 22, continuous_force = 3;         // [N]; > 0
  Eigen::Vector3d max_torque{515, 515, 170};           // handle axes [N mm]; > 0
  Eigen::Vector3d continuous_torque{188, 188, 48};     // [N mm]; > 0
  double thermal_time = 60;                            // time constant of the motors [s]; > 0. The continuous load heats them to 0.7
  double mode_frequency = 0,
         mode_damping = 0.05;  // structure between motor and handle, half of the mass on either side [Hz, 1]; 0: rigid; at most 500 Hz
  double jitter = 0;           // largest delay of a servo step, uniformly distributed [s]; 0..0.0004, and at most 0.4 of a step
  double lost_steps = 0;       // share of servo steps that are lost; 0..0.5
  std::uint64_t seed = 1;      // of jitter and lost steps
  Hand hand{"fine", 0.15, 4.5, 300};
  double release_at = std::numeric_limits<double>::infinity();  // the hand lets go [s]
  IntendedPath path;                                            // empty: always at the start pose
  double duration = std::numeric_limits<double>::infinity();    // the input ends [s]; > 0
};

class SimulatedDevice final : public Device {
 public:
  /// Starts at rest at the beginning of the path. @throws DeviceError Refused if a setting is out of range; the message
  /// names it.
  explicit SimulatedDevice(const SimulatedSettings& settings);
  ~SimulatedDevice() override { stop(); }

  /// The state that encoders do not report, after the last step; not available while Clock::Real runs.
  Configuration truePose() const noexcept { return {handle_.position, orientation_}; }
  Eigen::Vector3d trueVelocity() const noexcept { return handle_.velocity; }  // [mm/s]
  Eigen::Vector3d motorTemperature() const noexcept { return heat_.head<3>(); }
  Wrench actuated() const noexcept { return held_; }  // wrench of the motors in the last step
  /// Passivity observer (Hannaford and Ryu 2002): energy that the hand has put into the motors since start [N mm = mJ];
  /// negative: the motors have put out more.
  double energy() const noexcept { return energy_; }

 private:
  struct Body {
    Eigen::Vector3d position, velocity = Eigen::Vector3d::Zero();  // [mm, mm/s]
  };
  void begin(Clock) override;
  void rewind() noexcept override;
  bool advance() noexcept override;
  DeviceState measured() const noexcept;
  Wrench commanded(const Wrench& wrench) const noexcept;
  void move(int substeps) noexcept;
  void moveTranslation(int substeps, const Hand& hand, const Eigen::Vector3d& target, const Eigen::Vector3d& target_velocity) noexcept;
  void moveRotation(int substeps, const Hand& hand, const Configuration& from, const Configuration& to) noexcept;
  void heat() noexcept;
  double random() noexcept;  // in [0, 1)

  SimulatedSettings settings_;
  Body handle_, motor_;
  Quaternion orientation_{1, 0, 0, 0}, home_{1, 0, 0, 0};
  Eigen::Vector3d turn_rate_ = Eigen::Vector3d::Zero();  // device axes [rad/s]
  std::array<Wrench, 8> pending_;                        // ring buffer: commands that are still delayed
  Wrench held_;
  Eigen::Matrix<double, 6, 1> heat_ = Eigen::Matrix<double, 6, 1>::Zero();
  std::uint64_t steps_ = 0, random_state_ = 0;
  double time_ = 0;         // simulated time of the hand [s]
  int substeps_ = 100;      // in a servo step
  double substep_ = 1e-5;   // [s]
  int substeps_ahead_ = 0;  // substeps by which jitter delayed the beginning of this step
  double energy_ = 0;
};

}  // namespace spheretree::device
