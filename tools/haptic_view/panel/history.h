// SPDX-License-Identifier: GPL-3.0-or-later
// The last steps of a run for the plots and the figures. Units: s, N, N mm, mm, us.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "streams/recorded_step.h"

namespace spheretree::view {

struct PlotSample {
  double time;
  float force[3], torque[3];
  float depth;  // distance of the haptic tool behind the graphic tool: how far the hand presses
  float step_us;
  std::uint32_t faults;
};
PlotSample sampleOf(const player::RecordedStep& step);

/// Keeps at least the last kKept samples, in order and contiguous. A sample of an earlier time begins a new run.
class History {
 public:
  static constexpr std::size_t kKept = 60'000;  // a minute
  void add(const PlotSample& sample);
  void clear() { samples_.clear(); }
  std::span<const PlotSample> samples() const { return samples_; }

 private:
  std::vector<PlotSample> samples_;
};

/// The samples of the last `seconds`.
std::span<const PlotSample> lastOf(std::span<const PlotSample> samples, double seconds);

/// Of the step times of some samples [us]; zero if there are none.
struct StepTimes {
  double median = 0, p99 = 0, longest = 0;
};
StepTimes stepTimes(std::span<const PlotSample> samples);

}  // namespace spheretree::view
