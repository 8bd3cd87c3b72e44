// SPDX-License-Identifier: GPL-3.0-or-later
// Plays a scene: a device (simulated, replay or phantom) drives the tool, the runtime answers, what happens is recorded
// and summed up.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "recording.h"
#include "spheretree/builder/progress.h"
#include "spheretree/device/device.h"
#include "spheretree/device/phantom_device.h"
#include "spheretree/device/simulated_device.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "streams/live_streams.h"

namespace spheretree::player {

class ServoLoop;

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
  runtime::ContactSurface contact = runtime::ContactSurface::Skin;
  bool large_motion = true;        // of soft tissue, in constrained mode; else by the compliance of its rest alone
  bool passivity_control = false;  // or the scene says so; never with a replay, whose wrench nobody feels
  bool status_line = false;
};

/// How a run ended, with its summary.
enum class PlayEnd { Complete, Interrupted, DeviceFailed };

/// What looks at a run while it lasts, as a window does. Called from the thread that called play().
class PlayObserver {
 public:
  virtual ~PlayObserver() = default;
  /// Once, before anything moves.
  virtual void onScene(const runtime::SceneDescription& scene) = 0;
  /// Where each step goes and where the hand's goals come from. Must outlive the run.
  virtual view::LiveStreams* streams() = 0;
  /// Where a simulated hand means to be, if not on `path`, which the settings say; called in the thread of the steps.
  virtual device::IntendedPath handPath(device::IntendedPath path) { return path; }
  /// Over and over: after each step of a stepped run, at once after the one before in a real one. False ends the run.
  virtual bool onTurn(const device::DeviceStatus& status, ServoLoop& loop) = 0;
  /// Adds what it has to say of the run that has ended to the summary.
  virtual void addTo(nlohmann::ordered_json& /*summary*/) const {}
};

/// Runs to the end, or until an emergency stop is requested: zero wrench, clean stop, the recording whole under its
/// name.
/// `summary`: what --json prints (schema spheretree.run/1). Talks on stderr. `observer` may be null; without `seconds`
/// it says when a simulated hand ends.
/// @throws formats::FileError, formats::FormatError, device::DeviceError, builder::Cancelled, and what the observer
/// throws
PlayEnd play(const PlaySettings& settings, builder::Progress& progress, nlohmann::ordered_json& summary, PlayObserver* observer = nullptr);

/// What a scene file that names trees describes, or the built-in sample.
/// @throws formats::FileError, formats::FormatError, builder::Cancelled
runtime::SceneDescription describeScene(const std::filesystem::path& path, builder::Progress& progress);

/// `description`, checked and compiled; `path` of its file for messages. @throws formats::FormatError
runtime::Scene compiledScene(const runtime::SceneDescription& description, const std::filesystem::path& path);

/// Whether runs of these settings need a solver for soft tissue in `scene`.
bool movesTissue(const PlaySettings& settings, const runtime::Scene& scene);

/// How a recording of a run with these settings names what it belongs to.
RunIdentity identityOf(const PlaySettings& settings, const std::filesystem::path& recording, bool has_tissue);

/// The scene of a file that names trees, or the built-in sample, compiled.
/// @throws formats::FileError, formats::FormatError, builder::Cancelled
runtime::Scene loadScene(const std::filesystem::path& path, runtime::ContactSurface contact, builder::Progress& progress);

inline constexpr double kTourStopSeconds = 5;        // that a tour spends on each object
inline constexpr double kLongestTourSeconds = 3600;  // then it begins again: to look for a way down to 4,096 objects takes seconds

/// A hand's tour: down on every object in turn from above (+z), 2 mm deeper than the first touch, a small circle there,
/// and up again. Defined for all t >= 0; begins again after the last.
device::IntendedPath tourOf(const runtime::Scene& scene, double seconds = kLongestTourSeconds);

}  // namespace spheretree::player
