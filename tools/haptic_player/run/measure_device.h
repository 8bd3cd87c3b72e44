// SPDX-License-Identifier: GPL-3.0-or-later
// Measures a device, gently: at most 1 N, and pushes that lead to 12 mm/s. The handle has to be free in the middle of
// its workspace. Units: mm, N, s.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <vector>

#include "run/play.h"

namespace spheretree::player {

/// The renderer that moves the handle and watches it. No allocation in a step.
class DeviceProbe final : public device::Renderer {
 public:
  explicit DeviceProbe(double period);

  device::Rendered render(const device::DeviceState& state) noexcept override;
  bool isDone() const noexcept { return done_.load(std::memory_order_acquire); }

  // After the last step:
  double meanPeriod() const;                              // between two steps [s]
  double jitter(double share) const;                      // that this share of the steps does not exceed [s]
  std::optional<double> count() const;                    // of the encoder; nothing if positions are no multiples of one step [mm]
  std::array<std::optional<double>, 3> friction() const;  // force at which the handle begins to move along x, y, z [N]
  std::optional<double> latency() const;                  // from a force to the beginning of its motion [s]
  double fastest() const { return fastest_; }             // speed over 10 ms [mm/s]
  double hottest() const { return hottest_; }             // 0..1
  bool hasDrifted() const { return has_drifted_; }        // it left the middle of its workspace, and the measurement ended

 private:
  enum class Task { Rest, Push, Brake, Step, Done };
  static constexpr std::size_t kTrials = 100, kSamples = 512;

  double along(const Eigen::Vector3d& position) const { return sign() * (position - origin_)[axis_]; }
  double sign() const { return direction_ ? -1.0 : 1.0; }
  Eigen::Vector3d force(double size) const { return Eigen::Vector3d::Unit(axis_) * sign() * size; }
  void watch(const device::DeviceState& state) noexcept;
  void begin(Task task, const device::DeviceState& state) noexcept;
  Eigen::Vector3d push(const device::DeviceState& state, double spent) noexcept;
  Eigen::Vector3d step(const device::DeviceState& state, double spent) noexcept;
  void afterBrake(const device::DeviceState& state) noexcept;
  double response(double time, double pulse) const noexcept;
  std::size_t traceLength() const noexcept;

  double period_;
  Task task_ = Task::Rest, next_ = Task::Push;
  double begun_ = 0;  // of the task [s]
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  int axis_ = 0;
  bool direction_ = false;
  std::array<std::array<double, 2>, 3> friction_{};  // of each axis and direction; 0: none found
  double first_push_ = 0;                            // force at the first motion of this push; 0: none yet [N]
  double least_move_ = 1;                            // smallest step of the position [mm]
  double noise_ = 0;                                 // motion of a handle at rest [mm]
  std::size_t pulse_ = 2;                            // length of the step of the force [steps]
  bool is_counting_ = false;                         // the length is found: trials count
  std::size_t trial_ = 0, sample_ = 0;
  double reached_ = 0;                     // sum of the motions of the trials with this length [mm]
  std::array<double, kSamples> sum_{};     // position in each step after the beginning of the force, over all trials
  std::vector<double> intervals_, moves_;  // between steps [s]; steps of the position along x, y, z [mm]
  double last_time_ = -1, fastest_ = 0, hottest_ = 0;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero(), home_ = Eigen::Vector3d::Zero();
  bool has_drifted_ = false;
  std::array<Eigen::Vector3d, 128> track_{};  // the last positions, in a ring
  std::size_t seen_ = 0;
  std::atomic<bool> done_{false};
};

/// Measures the device of the settings, and returns what it found and proposes (schema spheretree.device_measures/1).
/// @throws device::DeviceError, also if the handle does not move
nlohmann::ordered_json measureDevice(const PlaySettings& settings);

}  // namespace spheretree::player
