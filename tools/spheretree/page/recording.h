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
  std::vector<float> penetration;  // of leaf spheres [mm]; empty if it was not recorded
  std::string scene;               // path of its scene file relative to the folder of the recording, or "sample"; empty if unknown
  /// Objects in the order of first touch, each with the number of steps in which its contact force was the largest.
  std::vector<std::pair<std::string, std::size_t>> touched;
  std::size_t steps() const { return time.size(); }
};

/// Finds columns by their names in the first line, in any order; others are ignored. penetration_mm, scene and touched
/// are optional.
/// @throws formats::FileError, formats::FormatError with line and column.
Recording readRecording(const std::filesystem::path& path);

/// A remark on a recording that is shown in the scene of `scene_file`; empty if it was made in that scene, or does not
/// name one.
/// @throws formats::FormatError if it was made in another scene that still exists.
std::string remarkOnScene(const Recording& recording, const std::filesystem::path& file, const std::filesystem::path& scene_file);

/// Energy that the renderer has absorbed from the hand up to each step [mJ]; each wrench is held until the next pose. A
/// negative value means that it has generated energy, which a passive object cannot. A motion of more than 10 mm in a
/// step is a restart of the hand: that step adds nothing.
/// Paper: B. Hannaford, J.-H. Ryu. Time-domain passivity control of haptic interfaces. IEEE T. Robotics and Automation
///         18(1), 2002.
std::vector<float> energyTaken(const Recording& recording);

struct Spectrum {
  std::vector<float> hertz, amplitude;  // of a sine of that frequency [unit of the values]
};

/// Mean over windows of up to 1024 values (Hann, half overlapping, with their means subtracted). Empty for fewer than
/// 16 values. `rate`: values a second. Paper: P. D. Welch. The use of fast Fourier transform for the estimation of
/// power spectra. IEEE Trans. Audio and Electroacoustics 15(2), 1967.
Spectrum spectrumOf(const std::vector<float>& values, double rate);

/// Magnitude of the force at each step [N].
std::vector<float> forceLength(const Recording& recording);

/// Steps, seconds, objects touched, largest force, torque, change of force within a step, distance between hand and
/// tool, energy, times, faults.
Json recordingFigures(const Recording& recording);

/// Charts of one run, as HTML.
std::string recordingCharts(const Recording& recording);

/// The data for replay: at most about 2000 evenly spaced steps. {name, time, poses (14 each), wrench (6 each)}
Json packRecording(PageData& data, const std::string& name, const Recording& recording);

}  // namespace spheretree::tool
