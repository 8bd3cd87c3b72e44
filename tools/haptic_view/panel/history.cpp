// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/history.h"

#include <algorithm>

namespace spheretree::view {

PlotSample sampleOf(const player::RecordedStep& step) {
  PlotSample out{};
  out.time = step.time;
  for (int k = 0; k < 3; ++k) {
    out.force[k] = static_cast<float>(step.wrench.force[k]);
    out.torque[k] = static_cast<float>(step.wrench.torque[k]);
  }
  out.depth = static_cast<float>((step.haptic.position - step.graphic.position).norm());
  out.step_us = static_cast<float>(step.total_us);
  out.faults = step.faults;
  return out;
}

void History::add(const PlotSample& sample) {
  if (!samples_.empty() && sample.time < samples_.back().time) samples_.clear();  // the run began again
  if (samples_.capacity() == 0) samples_.reserve(2 * kKept);
  if (samples_.size() == 2 * kKept) samples_.erase(samples_.begin(), samples_.end() - static_cast<std::ptrdiff_t>(kKept));
  samples_.push_back(sample);
}

std::span<const PlotSample> lastOf(std::span<const PlotSample> samples, double seconds) {
  if (samples.empty()) return samples;
  const double begin = samples.back().time - seconds;
  const auto first = std::partition_point(samples.begin(), samples.end(), [begin](const PlotSample& s) { return s.time < begin; });
  return samples.subspan(static_cast<std::size_t>(first - samples.begin()));
}

StepTimes stepTimes(std::span<const PlotSample> samples) {
  if (samples.empty()) return {};
  std::vector<float> us;
  us.reserve(samples.size());
  for (const PlotSample& s : samples) us.push_back(s.step_us);
  std::sort(us.begin(), us.end());
  const auto at = [&](double share) {
    return static_cast<double>(us[static_cast<std::size_t>(share * static_cast<double>(us.size() - 1))]);
  };
  return {at(0.5), at(0.99), static_cast<double>(us.back())};
}

}  // namespace spheretree::view
