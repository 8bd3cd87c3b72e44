// SPDX-License-Identifier: GPL-3.0-or-later
// A recording of haptic-player: its columns, the figures of a run, and its charts. Units: mm, N, N mm, s, mJ; world
// frame.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "page/chart.h"
#include "page/page.h"

namespace spheretree::tool {

struct Recording {
  std::vector<float> time;                       // [s], ascending
  std::vector<std::array<float, 7>> hand, tool;  // haptic and graphic tool: x y z [mm], quaternion w x y z
  std::vector<std::array<float, 6>> wrench;      // on the hand: force [N], torque [N mm]
  std::vector<float> total_us;                   // time of the step
  std::vector<float> pairs;
  std::vector<std::uint32_t> faults;
  std::vector<float> penetration;  // of leaf spheres [mm]; empty where it was not recorded
  std::string scene;               // path of its scene file from the folder of the recording, or "sample"; empty where it is not said
  /// Objects in the order of first touch, and in how many steps each was the one that was pressed most.
  std::vector<std::pair<std::string, std::size_t>> touched;
  std::size_t steps() const { return time.size(); }
};

/// Columns by their names in the first line, in any order; others are ignored. penetration_mm, scene and touched may
/// lack.
/// @throws formats::FileError, formats::FormatError with line and column.
Recording readRecording(const std::filesystem::path& path);

/// What is to be said of a recording that is shown in the scene of `scene_file`; empty if it was made there, or does
/// not say where.
/// @throws formats::FormatError if it was made in another scene, which is still there to compare.
std::string remarkOnScene(const Recording& recording, const std::filesystem::path& file, const std::filesystem::path& scene_file);

/// Energy that the renderer has taken from the hand until each step [mJ]: each wrench is held until the next pose.
/// Below 0 it has given energy, which a passive object cannot. A hand that is more than 10 mm farther in a step has
/// begun anew: that step adds nothing.
/// Paper: B. Hannaford, J.-H. Ryu. Time-domain passivity control of haptic interfaces. IEEE T. Robotics and Automation
///         18(1), 2002.
std::vector<float> energyTaken(const Recording& recording);

struct Spectrum {
  std::vector<float> hertz, amplitude;  // amplitude of a sine of that frequency [unit of the values]
};

/// Mean over windows of up to 1024 values (Hann, half overlapping, each without its mean). Empty for fewer than 16
/// values.
/// `rate`: values a second. Paper: P. D. Welch. The use of fast Fourier transform for the estimation of power spectra.
/// IEEE Trans. Audio and Electroacoustics 15(2), 1967.
Spectrum spectrumOf(const std::vector<float>& values, double rate);

/// Length of the force at each step [N].
std::vector<float> forceLength(const Recording& recording);

/// Steps, seconds, objects touched, largest force, torque, change of force within a step, distance between hand and
/// tool, energy, times, faults.
Json recordingFigures(const Recording& recording);

/// Charts of one run, HTML.
std::string recordingCharts(const Recording& recording);

/// What replay needs: at most about 2000 steps, evenly chosen. {name, time, poses (14 each), wrench (6 each)}
Json packRecording(PageData& data, const std::string& name, const Recording& recording);

}  // namespace spheretree::tool
