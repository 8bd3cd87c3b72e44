// SPDX-License-Identifier: GPL-3.0-or-later
// A hand on the simulated device, in closed loop with the scene of a trial, and measurements of the loop.
// Device, hands and their limits: docs/device.md. Units: mm, N, N mm, s, mJ.
#pragma once

#include <vector>

#include "scenarios/scenario_run.h"
#include "spheretree/device/simulated_device.h"

namespace spheretree::player {

struct ClosedLoop {
  std::vector<Wrench> sent;          // wrench of the motors in each millisecond
  std::vector<Configuration> poses;  // true poses, in each millisecond
  double lowest_energy = 0;          // smallest energy of the passivity observer, including torques; <= 0 [mJ]
  double leak = 0;                   // energy that a sampled and delayed spring generates for any renderer [mJ]

  std::vector<double> force(int axis, std::size_t begin, std::size_t end = ~std::size_t{0}) const;
  std::vector<double> torque(int axis, std::size_t begin, std::size_t end = ~std::size_t{0}) const;
  /// Generated energy in excess of `factor` times the leak; negative: the renderer generated less than that [mJ].
  double energyBeyond(double factor) const { return -lowest_energy - factor * leak; }
};

enum class Friction { On, Off };  // Coulomb friction of the device; viscous friction is always on

/// Settings for a hand of this name, with a delay of `delay` whole steps.
device::SimulatedSettings handAt(const char* hand, int delay, Friction friction, device::IntendedPath path);

enum class Passivity { Free, Controlled };  // by the device: docs/device.md

/// Runs without start guard and ramp, since the scenarios measure the renderer's own behaviour. Ctrl-C ends it.
/// @throws builder::Cancelled
/// `milliseconds`: its length. `rate`: that of the trial [Hz].
ClosedLoop runHand(const ScenarioContext& context, ScenarioRun& trial, const device::SimulatedSettings& settings, int milliseconds,
                   Passivity passivity = Passivity::Free, double rate = 1000);

/// Spectrum of a 1 kHz signal from 30 to 500 Hz: Welch's method, Hann windows of 1000 samples that overlap by half. All
/// values are 0 for less than one window.
struct Spectrum {
  double rms = 0;           // in the unit of the signal
  double largest_line = 0;  // amplitude of the strongest line
};
Spectrum roughness(const std::vector<double>& signal);
/// Of all three components: root of the sum of squares, and the largest line of any component.
Spectrum forceRoughness(const ClosedLoop& loop, std::size_t begin, std::size_t end = ~std::size_t{0});
Spectrum torqueRoughness(const ClosedLoop& loop, std::size_t begin, std::size_t end = ~std::size_t{0});

double peakToPeak(const std::vector<double>& signal);

}  // namespace spheretree::player
