// SPDX-License-Identifier: GPL-3.0-or-later
// Plays a scene: a device (simulated, a replay or one that a hand holds) moves the tool, the runtime responds, and the
// run is recorded and summarised.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "run/recording.h"
#include "spheretree/builder/progress.h"
#include "spheretree/device/device.h"
#include "spheretree/device/open_device.h"
#include "spheretree/device/simulated_device.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "streams/live_streams.h"

namespace spheretree::player {

class ServoLoop;

enum class DeviceKind { Simulated, Replay, Real };

struct PlaySettings {
  std::filesystem::path scene;  // empty: the built-in sample, a dental probe over a molar
  DeviceKind device = DeviceKind::Simulated;
  std::string device_name;           // real: what device::openDevice() opens
  double rate = 1000;                // servo steps in a second [Hz]
  std::filesystem::path trajectory;  // replay: the poses; simulated: the path that the hand intends; empty: a tour of the objects
  runtime::Mode mode = runtime::Mode::Constrained;
  device::Clock clock = device::Clock::Real;
  std::optional<double> seconds;  // absent: the whole trajectory, 10 s for a simulated hand, or until Ctrl-C [s]
  std::filesystem::path record;   // empty: no recording
  std::string hand = "fine";      // of the simulated device
  device::OpenSettings open;
  std::uint32_t clutch_buttons = 0;   // real: device::SafetySettings::clutch_buttons
  std::uint32_t spindle_buttons = 0;  // real: ServoLoop::Options::spindle_buttons
  double carried_weight = 0;          // real: of the handle, which the motors carry [N]
  runtime::ContactSurface contact = runtime::ContactSurface::Skin;
  bool large_motion = true;        // of soft tissue, in constrained mode; false: only the compliance of its shape at rest
  bool passivity_control = false;  // also enabled if the scene says so; never with a replay, since nobody feels its wrench
  bool status_line = false;
};

/// Opens the device of the settings: a real one; or a replay or a simulated hand, for which no scene is needed.
/// @throws device::DeviceError, formats::FileError, formats::FormatError
std::unique_ptr<device::Device> openDeviceOf(const PlaySettings& settings);

/// The safety settings, apart from those of a scene.
device::SafetySettings safetyOf(const PlaySettings& settings);

/// How a run ended.
enum class PlayEnd { Complete, Interrupted, DeviceFailed };

/// An observer of a run, such as a window. It is called from the thread that called play().
class PlayObserver {
 public:
  virtual ~PlayObserver() = default;
  /// Called once, before anything moves.
  virtual void onScene(const runtime::SceneDescription& scene) = 0;
  /// The streams that receive each step and supply the hand's targets. They must outlive the run.
  virtual view::LiveStreams* streams() = 0;
  /// Replaces the path that a simulated hand intends (`path`, from the settings); evaluated in the thread of the steps.
  virtual device::IntendedPath handPath(device::IntendedPath path) { return path; }
  /// Called repeatedly: after each step of a stepped run, continuously in a real-time run. May change the pace of the
  /// device or restart it. Returns false to end the run.
  virtual bool onTurn(device::Device& device, ServoLoop& loop) = 0;
  /// Adds the observer's figures of the finished run to the summary.
  virtual void addTo(nlohmann::ordered_json& /*summary*/) const {}
};

/// Runs to the end, or until an emergency stop is requested: zero wrench, clean stop, and a complete recording under
/// its name. Messages go to stderr. `summary` receives the JSON that --json prints (schema spheretree.run/1).
/// `observer` may be null; without `seconds` it decides when a simulated hand ends.
/// @throws formats::FileError, formats::FormatError, device::DeviceError, builder::Cancelled, and exceptions of the
/// observer
PlayEnd play(const PlaySettings& settings, builder::Progress& progress, nlohmann::ordered_json& summary, PlayObserver* observer = nullptr);

/// The description of a scene file that names trees, or of the built-in sample.
/// @throws formats::FileError, formats::FormatError, builder::Cancelled
runtime::SceneDescription describeScene(const std::filesystem::path& path, builder::Progress& progress);

/// Checks and compiles `description`; `path` of its file for messages. @throws formats::FormatError
runtime::Scene compiledScene(const runtime::SceneDescription& description, const std::filesystem::path& path);

/// Whether runs with these settings need a solver for the soft tissue in `scene`.
bool movesTissue(const PlaySettings& settings, const runtime::Scene& scene);

/// The identity that a recording of a run with these settings stores.
RunIdentity identityOf(const PlaySettings& settings, const std::filesystem::path& recording, bool has_tissue);

/// Loads and compiles the scene of a file that names trees, or the built-in sample.
/// @throws formats::FileError, formats::FormatError, builder::Cancelled
runtime::Scene loadScene(const std::filesystem::path& path, runtime::ContactSurface contact, builder::Progress& progress);

inline constexpr double kTourStopSeconds = 5;  // time of a tour on each object
inline constexpr double kLongestTourSeconds =
    3600;  // then the tour begins again, because the search for paths down to 4,096 objects takes seconds

/// A tour of the hand: it approaches every object in turn from above (+z), presses 2 mm deeper than the first touch,
/// makes a small circle there, and rises again. Defined for all t >= 0; begins again after the last object.
device::IntendedPath tourOf(const runtime::Scene& scene, double seconds = kLongestTourSeconds);

}  // namespace spheretree::player
