// SPDX-License-Identifier: GPL-3.0-or-later
// Plays a scene: a device (simulated, replay or phantom) drives the tool, the runtime answers, what happens is recorded and summed up.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "spheretree/builder/progress.h"
#include "spheretree/device/device.h"
#include "spheretree/device/phantom_device.h"
#include "spheretree/device/simulated_device.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"

namespace spheretree::player {

enum class DeviceKind { Simulated, Replay, Phantom };

struct PlaySettings {
  std::filesystem::path scene;  // empty: the built-in sample, a dental probe over a molar
  DeviceKind device = DeviceKind::Simulated;
  std::filesystem::path trajectory;  // replay: the poses; simulated: where the hand means to be; empty: a tour of the objects
  runtime::Mode mode = runtime::Mode::Constrained;
  device::Clock clock = device::Clock::Real;
  std::optional<double> seconds;  // absent: the whole trajectory, 10 s of a simulated hand, or until Ctrl-C [s]
  std::filesystem::path record;   // empty: no recording
  std::string hand = "fine";      // of the simulated device
  device::PhantomSettings phantom;
  bool bridges = true;  // runtime::SceneDescription::bridges
  bool status_line = false;
};

/// How a run ended, with its summary.
enum class PlayEnd { Complete, Interrupted, DeviceFailed };

/// Runs to the end, or until an emergency stop is requested: zero wrench, clean stop, the recording whole under its name.
/// `summary`: what --json prints (schema spheretree.run/1). Talks on stderr.
/// @throws formats::FileError, formats::FormatError, device::DeviceError, builder::Cancelled
PlayEnd play(const PlaySettings& settings, builder::Progress& progress, nlohmann::ordered_json& summary);

/// The scene of a file that names trees, or the built-in sample.
/// @throws formats::FileError, formats::FormatError, builder::Cancelled
runtime::Scene loadScene(const std::filesystem::path& path, bool bridges, builder::Progress& progress);

inline constexpr double kTourStopSeconds = 5;  // that a tour spends on each object

/// A hand's tour: down on every object in turn from above (+z), 2 mm deeper than the first touch, a small circle there, and up again.
/// Defined for all t >= 0; begins again after the last.
device::IntendedPath tourOf(const runtime::Scene& scene);

}  // namespace spheretree::player
