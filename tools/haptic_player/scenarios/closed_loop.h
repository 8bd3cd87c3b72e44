// SPDX-License-Identifier: GPL-3.0-or-later
// A hand on the simulated device against a trial's scene, in closed loop, and what is measured of it.
// Device, hands and their limits: docs/device.md. Units: mm, N, N mm, s, mJ.
#pragma once

#include <vector>

#include "scenarios/scenario_run.h"
#include "spheretree/device/simulated_device.h"

namespace spheretree::player {

struct ClosedLoop {
  std::vector<Wrench> sent;          // what the motors gave, step by step
  std::vector<Configuration> poses;  // true
  double lowest_energy = 0;          // of the passivity observer, <= 0; torques count [mJ]
  double leak = 0;                   // what a sampled and delayed spring gives away whatever its renderer does [mJ]

  std::vector<double> force(int axis, std::size_t begin, std::size_t end = ~std::size_t{0}) const;
  std::vector<double> torque(int axis, std::size_t begin, std::size_t end = ~std::size_t{0}) const;
  /// Energy that was given beyond `factor` times the leak; below 0: the renderer took what it should [mJ].
  double energyBeyond(double factor) const { return -lowest_energy - factor * leak; }
};

enum class Friction { On, Off };  // Coulomb's, of the device; the viscous one stays

/// A hand by its name, `delay` whole steps late.
device::SimulatedSettings handAt(const char* hand, int delay, Friction friction, device::IntendedPath path);

enum class Passivity { Free, Controlled };  // by the device: docs/device.md

/// Without start guard and ramp: a context asks for the renderer's own behaviour. Ctrl-C ends it. @throws
/// builder::Cancelled
ClosedLoop runHand(const ScenarioContext& context, ScenarioRun& trial, const device::SimulatedSettings& settings, int steps,
                   Passivity passivity = Passivity::Free);

/// Of a signal of 1 kHz from 30 to 500 Hz: Welch's method, Hann windows of 1000 samples that overlap by half. 0 for
/// less than one window.
struct Spectrum {
  double rms = 0;           // unit of the signal
  double largest_line = 0;  // amplitude of the strongest line
};
Spectrum roughness(const std::vector<double>& signal);
/// Of the three components together: root of the sum of squares, largest line of any.
Spectrum forceRoughness(const ClosedLoop& loop, std::size_t begin, std::size_t end = ~std::size_t{0});
Spectrum torqueRoughness(const ClosedLoop& loop, std::size_t begin, std::size_t end = ~std::size_t{0});

double peakToPeak(const std::vector<double>& signal);

}  // namespace spheretree::player
