// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/view_options.h"

#include "program_end.h"
#include "run_files.h"

#ifdef SPHERETREE_VIEW
#include "view/live_view.h"
#include "view/pictures.h"
#include "view/replay_view.h"
#include "window/window.h"
#endif

namespace spheretree::player {

using tool::UsageError;

void addViewOptions(CLI::App& cli, ViewOptions& o) {
  cli.add_flag("--view", o.view, "Open a window that shows the run, and in which the mouse moves the hand");
  cli.add_option("--hand-from", o.hand_from,
                 "With --view: input that moves the simulated hand: mouse, keyboard, gamepad, spacemouse or file; default mouse. The hand "
                 "begins where --trajectory begins")
      ->check(CLI::IsMember({"mouse", "keyboard", "gamepad", "spacemouse", "file"}));
  CLI::Option* replay = cli.add_option("--replay", o.replay, "Show a recording (CSV) with a time slider, without computing steps again");
  cli.add_option("--compare", o.compare, "With --replay: another recording, shown beside it")->needs(replay);
  CLI::Option* picture =
      cli.add_option("--picture", o.picture, "Draw a picture (PNG) of a stepped run or of a recording, without a display");
  cli.add_option("--at", o.at, "With --picture: step to draw, or FROM:TO:EVERY for numbered pictures; default 2000")->needs(picture);
  cli.add_option("--size", o.size, "With --view or --picture: pixels as WIDTHxHEIGHT, each 64 to 8192; default 1280x800");
  cli.add_option("--theme", o.theme, "With --view or --picture: dark or light; default dark")->check(CLI::IsMember({"dark", "light"}));
  cli.add_option("--show", o.show,
                 "With --view or --picture: meshes, spheres, bounds (bounding spheres) or contact (the surface used for contact); default "
                 "meshes")
      ->check(CLI::IsMember({"meshes", "spheres", "bounds", "contact"}));
  cli.add_option("--from", o.from,
                 "With --view or --picture: direction from the tool to the eye, three numbers; default: a direction in which the tool is "
                 "well visible")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(CLI::Range(-1e6, 1e6));
  cli.add_option("--within", o.within,
                 "With --view or --picture: size of the region shown around the tool, 0.1 to 10000 mm; default: from the scene")
      ->check(CLI::Range(0.1, 10000.0));
  cli.add_flag("--follow", o.follow, "With --view or --picture: the view moves with the tool");
  cli.add_option("--panels", o.panels, "With --view or --picture: panels and plots, on or off; default on")
      ->check(CLI::IsMember({"on", "off"}));
  cli.add_option("--scale", o.scale,
                 "With --view or --picture: scale of text and marks, 0.5 to 4; default: that of the display, 1 for pictures")
      ->check(CLI::Range(0.5, 4.0));
}

#ifdef SPHERETREE_VIEW

view::Look lookOf(const ViewOptions& o) {
  view::Look look;
  look.theme = o.theme == "light" ? view::ThemeKind::Light : view::ThemeKind::Dark;
  look.objects = look.tool = o.show == "spheres"   ? view::Geometry::Spheres
                             : o.show == "bounds"  ? view::Geometry::Bounds
                             : o.show == "contact" ? view::Geometry::Contact
                                                   : view::Geometry::Meshes;
  return look;
}

view::CameraWish wishOf(const ViewOptions& o) {
  view::CameraWish wish;
  if (o.from.size() == 3) wish.from = Eigen::Vector3d(o.from[0], o.from[1], o.from[2]);
  if (wish.from && !(wish.from->norm() > 0)) throw UsageError("--from is the zero vector. Give a direction to look from, such as 1,-2,1");
  wish.within = o.within;
  return wish;
}

ViewSettings settingsOf(const ViewOptions& o) {
  ViewSettings out;
  if (!o.size.empty()) {
    const auto [width, height] = pictureSize(o.size);
    out.width = width;
    out.height = height;
  }
  out.scale = o.scale;
  out.look = lookOf(o);
  out.wish = wishOf(o);
  out.panels = o.panels == "on";
  out.follow = o.follow;
  return out;
}

LiveView::Options windowOf(const ViewOptions& o) { return {settingsOf(o)}; }

PictureSettings picturesOf(const ViewOptions& o) {
  PictureSettings out{settingsOf(o), o.picture, pictureSteps(o.at.empty() ? "2000" : o.at)};
  if (!(out.scale > 0)) out.scale = 1;
  return out;
}

void checkPictures(const ViewOptions& o) {
  if (o.picture.empty()) return;
  if (o.view) throw UsageError("--picture draws into a file and --view into a window. Leave one of them out");
  const tool::RunFiles files;
  const PictureSettings pictures = picturesOf(o);
  files.willWrite(o.picture, {".png"}, "the picture", false);
  if (!pictures.steps.isOne()) files.willWrite(pictureName(o.picture, pictures.steps, pictures.steps.first));
}

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
  if (play_settings.device == DeviceKind::Phantom)
    throw UsageError("--picture is not for --device phantom: draw its recording, by --replay");
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
