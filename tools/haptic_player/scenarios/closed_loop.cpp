// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenarios/closed_loop.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace spheretree::player {
namespace {

/// The runtime as the renderer of a device.
class LoopRenderer final : public device::Renderer {
 public:
  explicit LoopRenderer(ScenarioRun& trial) : rig_(trial) {}
  device::Rendered render(const device::DeviceState& state) noexcept override { return {rig_.to(state.handle).wrench, 0, false}; }

 private:
  ScenarioRun& rig_;
};

/// v.K v T^2 of a step: twice the energy of the springs for the part of its motion along the wrench, which is the only
/// direction in which a contact without friction is stiff [mJ]. Lengths of motions and wrenches are those of the metric
/// of the two springs.
double squeezed(const runtime::Coupling& coupling, const Displacement& way, const Wrench& wrench) {
  const double length2 = wrench.force.squaredNorm() / coupling.translation + wrench.torque.squaredNorm() / coupling.rotation;
  const double along = way.translation.dot(wrench.force) + way.rotation.dot(wrench.torque);
  return length2 > 1e-12 ? along * along / length2 : 0;
}

template <class Value>
std::vector<double> part(const std::vector<Wrench>& sent, std::size_t begin, std::size_t end, const Value& value) {
  std::vector<double> out;
  for (std::size_t i = begin; i < std::min(end, sent.size()); ++i) out.push_back(value(sent[i]));
  return out;
}

template <class Component>
Spectrum together(const Component& component) {
  Spectrum sum;
  for (int axis = 0; axis < 3; ++axis) {
    const Spectrum s = roughness(component(axis));
    sum.rms = std::hypot(sum.rms, s.rms);
    sum.largest_line = std::max(sum.largest_line, s.largest_line);
  }
  return sum;
}

}  // namespace

std::vector<double> ClosedLoop::force(int axis, std::size_t begin, std::size_t end) const {
  return part(sent, begin, end, [axis](const Wrench& w) { return w.force[axis]; });
}
std::vector<double> ClosedLoop::torque(int axis, std::size_t begin, std::size_t end) const {
  return part(sent, begin, end, [axis](const Wrench& w) { return w.torque[axis]; });
}

device::SimulatedSettings handAt(const char* hand, int delay, Friction friction, device::IntendedPath path) {
  device::SimulatedSettings settings;
  settings.hand = *device::findHand(hand);
  settings.delay = delay;
  settings.path = std::move(path);
  if (friction == Friction::Off) settings.coulomb = settings.coulomb_rotation = 0;
  return settings;
}

ClosedLoop runHand(const ScenarioContext& context, ScenarioRun& trial, const device::SimulatedSettings& settings, int milliseconds,
                   Passivity passivity, double rate) {
  device::SimulatedDevice simulated(settings);
  LoopRenderer renderer(trial);
  device::SafetySettings safety;
  safety.start_guard = false;
  safety.max_force = 22;
  safety.force_slew = safety.torque_slew = 1e5;
  safety.ramp_force_slew = safety.ramp_torque_slew = 1e5;
  safety.ramp = 0.001;
  safety.fade_force = 1e5;
  safety.passivity_control = passivity == Passivity::Controlled;
  safety.period = 1 / rate;
  simulated.start(renderer, safety, device::Clock::Stepped);
  ClosedLoop loop;
  Configuration last = simulated.truePose();
  const auto steps = static_cast<int>(std::lround(milliseconds * rate / 1000));
  for (int n = 0; n < steps && simulated.step(); ++n) {
    if (n % 256 == 0) context.progress.check();
    const Wrench sent = simulated.actuated();
    // The measures look at milliseconds: a slower loop holds its values, of a faster one they see one in several.
    while (static_cast<double>(loop.sent.size()) * rate < 1000.0 * (n + 1)) {
      loop.sent.push_back(sent);
      loop.poses.push_back(simulated.truePose());
    }
    loop.lowest_energy = std::min(loop.lowest_energy, simulated.energy());
    loop.leak += (0.5 + settings.delay) * squeezed(trial.coupling(), displacementBetween(last, simulated.truePose()), sent);
    last = simulated.truePose();
  }
  simulated.stop();
  return loop;
}

Spectrum roughness(const std::vector<double>& signal) {
  constexpr int kWindow = 1000, kLow = 30, kHigh = kWindow / 2;
  if (signal.size() < kWindow) return {};
  std::array<double, kHigh + 1> power{};  // of each line, summed over the windows
  int windows = 0;
  for (std::size_t begin = 0; begin + kWindow <= signal.size(); begin += kWindow / 2, ++windows) {
    double mean = 0;
    for (int i = 0; i < kWindow; ++i) mean += signal[begin + static_cast<std::size_t>(i)] / kWindow;
    for (int k = kLow; k <= kHigh; ++k) {
      std::complex<double> sum = 0, phase = 1;
      const std::complex<double> turn = std::polar(1.0, -2 * std::numbers::pi * k / kWindow);
      for (int i = 0; i < kWindow; ++i, phase *= turn)
        sum += phase * (signal[begin + static_cast<std::size_t>(i)] - mean) * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / kWindow));
      const double amplitude = 2 * std::abs(sum) / (0.5 * kWindow);
      power[static_cast<std::size_t>(k)] += 0.5 * amplitude * amplitude;
    }
  }
  Spectrum out;
  for (const double p : power) {
    out.rms += p / 1.5 / windows;  // 1.5 bins: the noise bandwidth of the Hann window
    out.largest_line = std::max(out.largest_line, std::sqrt(2 * p / windows));
  }
  out.rms = std::sqrt(out.rms);
  return out.rms > 1e-12 ? out : Spectrum{};  // a smaller value is rounding of a constant signal
}

Spectrum forceRoughness(const ClosedLoop& loop, std::size_t begin, std::size_t end) {
  return together([&](int axis) { return loop.force(axis, begin, end); });
}
Spectrum torqueRoughness(const ClosedLoop& loop, std::size_t begin, std::size_t end) {
  return together([&](int axis) { return loop.torque(axis, begin, end); });
}

double peakToPeak(const std::vector<double>& signal) {
  const auto [low, high] = std::minmax_element(signal.begin(), signal.end());
  return signal.empty() ? 0 : *high - *low;
}

}  // namespace spheretree::player
