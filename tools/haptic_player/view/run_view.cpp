// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/run_view.h"

#include "program_end.h"

#ifdef SPHERETREE_VIEW
#include "view/replay_view.h"
#include "view/settings_of_options.h"
#include "window/window.h"
#endif

namespace spheretree::player {

using tool::UsageError;

#ifdef SPHERETREE_VIEW

namespace {

view::HandSource handOf(const ViewOptions& o, const PlaySettings& play) {
  if (play.device != DeviceKind::Simulated) {
    if (!o.hand_from.empty()) throw UsageError("--hand-from is for the simulated device. Leave out --device, or --hand-from");
    return view::HandSource::File;
  }
  if (o.hand_from == "file" && play.trajectory.empty()) throw UsageError("--hand-from file needs --trajectory IN.csv");
  if (o.hand_from == "file") return view::HandSource::File;
  if (o.hand_from == "keyboard") return view::HandSource::Keyboard;
  if (o.hand_from == "gamepad") return view::HandSource::Gamepad;
  if (o.hand_from == "spacemouse") return view::HandSource::SpaceMouse;
  return view::HandSource::Mouse;
}

}  // namespace

bool canShowWindow() { return view::hasDisplay(); }
const char* whyNoWindow() { return "no display, so no window: a simulated hand plays the built-in scene for 10 s (--help says what else)"; }

PlayEnd runView(const ViewOptions& o, PlaySettings& play_settings, builder::Progress& progress, nlohmann::ordered_json& summary) {
  checkPictures(o);
  if (!o.replay.empty()) {
    if (!o.view && o.picture.empty()) throw UsageError("--replay shows a recording: add --view, or --picture OUT.png");
    std::vector<ReplayedRun> runs;
    for (const std::filesystem::path& file : {o.replay, o.compare})
      if (!file.empty()) runs.push_back(replayedRun(file, play_settings.scene, progress));
    Replay replay(std::move(runs));
    if (o.picture.empty())
      showReplay(replay, windowOf(o), progress);
    else
      drawReplay(replay, picturesOf(o), progress);
    return PlayEnd::Complete;
  }
  if (o.picture.empty()) {
    LiveView::Options options = windowOf(o);
    options.hand = handOf(o, play_settings);
    LiveView view(options, play_settings);
    return play(play_settings, progress, summary, &view);
  }
  if (play_settings.device == DeviceKind::Real)
    throw UsageError("--picture is not for --device " + play_settings.device_name + ": draw its recording, by --replay");
  const PictureSettings pictures = picturesOf(o);
  play_settings.clock = device::Clock::Stepped;
  PictureObserver observer(pictures, play_settings);
  const PlayEnd end = play(play_settings, progress, summary, &observer);
  if (observer.count() == 0 && end == PlayEnd::Complete)
    throw UsageError("--at " + std::to_string(pictures.steps.first) + ": the run ended before this step. Choose an earlier one");
  return end;
}

#else

bool canShowWindow() { return false; }
const char* whyNoWindow() { return "built without a window: a simulated hand plays the built-in scene for 10 s (--help says what else)"; }

constexpr const char* kNotBuilt =
    "this haptic-player was built without its view. Install libglfw3-dev, libimgui-dev and libegl-dev, and build it again "
    "(-DSPHERETREE_VIEW=ON)";
PlayEnd runView(const ViewOptions&, PlaySettings&, builder::Progress&, nlohmann::ordered_json&) { throw UsageError(kNotBuilt); }
int viewScenario(const ViewOptions&, const Scenario&, ScenarioContext&, builder::Progress&) { throw UsageError(kNotBuilt); }

#endif

}  // namespace spheretree::player
