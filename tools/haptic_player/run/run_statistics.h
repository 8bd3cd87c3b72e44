// SPDX-License-Identifier: GPL-3.0-or-later
// The summary of a run: times, penetration, force steps, energy, faults. It is updated in the servo loop, without
// allocation.
// Units: mm, N, N mm, s, mJ (= N mm); times in us.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>

#include "run/recording.h"
#include "spheretree/runtime/step.h"

namespace spheretree::player {

/// Counts durations in bins of equal ratio, so that any quantile is accurate to 1.1 %, for any number of samples.
class TimeHistogram {
 public:
  void add(double us) noexcept;
  std::uint64_t count() const { return count_; }
  double largest() const { return largest_; }  // exact [us]
  /// Smallest duration that a share `q` in (0, 1] of the samples does not exceed [us]; 0 without samples.
  double quantile(double q) const;

 private:
  static constexpr int kPerOctave = 64, kOctaves = 32;  // from 1 ns to 4 s
  std::array<std::uint32_t, kPerOctave * kOctaves> bins_{};
  std::uint64_t count_ = 0;
  double largest_ = 0;
};

/// median, p99, p99_9 and max of durations [us].
nlohmann::ordered_json timesJson(const TimeHistogram& durations);

/// Passivity observer: the energy that the renderer has absorbed from the hand, E[n] = -sum F . dx + torque . dtheta
/// over the ticks, where each wrench is held until the next pose. A negative value means that the renderer has
/// generated energy. Paper: B. Hannaford, J.-H. Ryu. Time-domain passivity control of haptic interfaces. IEEE Trans.
/// Robotics and Automation 18(1), 2002.
class PassivityObserver {
 public:
  void add(const Configuration& pose, const Wrench& wrench) noexcept;
  /// The next pose is not reached from the last one.
  void restart() noexcept { started_ = false; }
  double energy() const { return energy_; }      // current value [mJ]
  double smallest() const { return smallest_; }  // smallest value so far, <= 0 [mJ]
  double largest() const { return largest_; }    // largest value so far, >= 0 [mJ]

 private:
  Configuration pose_;
  Wrench wrench_;
  bool started_ = false;
  double energy_ = 0, smallest_ = 0, largest_ = 0;
};

/// What the longest step of a run did.
struct LongestStep {
  double time = 0;                        // of its tick [s]
  double clock_us = 0, processor_us = 0;  // how long it took
  std::uint32_t pairs = 0, contacts = 0;  // leaves near objects, rows that carry force
  const char* kind() const { return time == 0 ? "first" : contacts > 0 ? "in contact" : pairs > 0 ? "near an object" : "free"; }
};

class RunStatistics {
 public:
  /// `period`: of the steps [s].
  explicit RunStatistics(double period = 1e-3) : period_us_(1e6 * period) {}
  /// `processor_us`: processor time of the step's thread; the remainder of row.total_us was used by other programs.
  void add(const RecordedStep& row, double processor_us) noexcept;
  /// The next step does not follow from the last one; everything is counted on.
  void restart() noexcept;

  std::uint64_t steps() const { return steps_; }
  const TimeHistogram& total() const { return total_; }
  /// For --json: steps, time_us, longest_step, steps_over_ms, largest_penetration_mm, wrench_step, energy_mj, faults.
  nlohmann::ordered_json toJson() const;
  /// For --json: the number of steps in which passivity control was active, and its largest wrench.
  nlohmann::ordered_json passivityJson() const;

 private:
  double period_us_;
  TimeHistogram find_, rows_, qp_, total_, processor_;
  LongestStep longest_;
  PassivityObserver energy_;
  Wrench last_wrench_;
  bool follows_ = false;  // the next step from last_wrench_
  double force_step_ = 0, torque_step_ = 0, penetration_ = 0, largest_force_ = 0;
  double passivity_force_ = 0, passivity_torque_ = 0, passivity_debt_ = 0;
  std::uint64_t passivity_steps_ = 0;
  std::uint64_t steps_ = 0, over_by_clock_ = 0, over_by_processor_ = 0;
  std::array<std::uint64_t, 7> faults_{};
};

}  // namespace spheretree::player
