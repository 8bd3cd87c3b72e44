// SPDX-License-Identifier: Apache-2.0
// A hand that taps on a sampled wall, presses and holds still, and the force on it.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "spheretree/device/simulated_device.h"

namespace spheretree::test {

/// Wall at z = 0, or angular spring stop about x at 0: its force is proportional to depth.
struct Wall final : device::Renderer {
  bool angular = false;
  double stiffness = 1;        // [N/mm, N mm/rad]
  std::vector<double> answer;  // force or torque of each step [N, N mm]
  device::Rendered render(const device::DeviceState& state) noexcept override {
    const double depth = angular ? -rotationVector(state.handle.orientation).x() : -state.handle.position.z();
    const double push = std::max(0.0, stiffness * depth);
    answer.push_back(push);
    return angular ? device::Rendered{{{0, 0, 0}, {push, 0, 0}}, 0, false} : device::Rendered{{{0, 0, push}, {0, 0, 0}}, 0, false};
  }
};

/// Without safety rules, so that the device meets the renderer directly.
inline device::SafetySettings noSafety() {
  device::SafetySettings s;
  s.start_guard = false;
  s.max_force = s.force_slew = s.torque_slew = s.fade_speed = s.pose_jump = s.continuous_force = 1e6;
  s.max_torque = s.continuous_torque = Eigen::Vector3d::Constant(1e6);
  return s;
}

/// Root mean square above 30 Hz: second-order Butterworth high-pass at 1 kHz over all samples, evaluated from `first`
/// on.
inline double roughness(const std::vector<double>& signal, std::size_t first) {
  const double w = std::tan(M_PI * 30 / 1000), c = 1 / (1 + std::sqrt(2.0) * w + w * w);
  const double a1 = 2 * c * (w * w - 1), a2 = c * (1 - std::sqrt(2.0) * w + w * w);
  double x1 = 0, x2 = 0, y1 = 0, y2 = 0, sum = 0;
  for (std::size_t n = 0; n < signal.size(); ++n) {
    const double y = c * (signal[n] - 2 * x1 + x2) - a1 * y1 - a2 * y2;
    x2 = x1, x1 = signal[n], y2 = y1, y1 = y;
    if (n >= first) sum += y * y;
  }
  return std::sqrt(sum / static_cast<double>(signal.size() - first));
}

struct Press {
  double ring;   // peak to peak while holding still [N, N mm]
  double rough;  // rms above 30 Hz
};

/// The hand comes from 1 mm (1 degree) before the wall at `speed` [mm/s, rad/s], intends a depth whose force is `push`
/// [N, N mm], and holds. Evaluated from `settle` [s] after the end of its intended motion, for 0.9 s.
inline Press press(device::SimulatedSettings settings, double stiffness, bool angular, double push, double speed, double settle) {
  const double hand = angular ? settings.hand.angular_stiffness * 1000 : settings.hand.stiffness / 1000;  // [N mm/rad, N/mm]
  const double before = angular ? 0.0175 : 1, depth = push / hand;
  settings.path = [=](double t) {
    const double at = std::max(before - speed * t, -depth);
    return angular ? Configuration{{0, 0, 0}, rotationOf({at, 0, 0})} : Configuration{{0, 0, at}, {1, 0, 0, 0}};
  };
  const double stop = (before + depth) / speed;
  settings.duration = stop + settle + 0.9;
  settings.max_force = 100;
  settings.max_torque = {1e4, 1e4, 1e4};
  device::SimulatedDevice device(settings);
  Wall wall;
  wall.angular = angular;
  wall.stiffness = stiffness;
  device.start(wall, noSafety(), device::Clock::Stepped);
  while (device.step()) {
  }
  const std::size_t first = static_cast<std::size_t>((stop + settle) * 1000);
  const auto [low, high] = std::minmax_element(wall.answer.begin() + static_cast<std::ptrdiff_t>(first), wall.answer.end());
  return {*high - *low, roughness(wall.answer, first)};
}

}  // namespace spheretree::test
