// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/replay_view.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "program_end.h"
#include "run/play.h"
#include "terminal.h"
#include "view/run_panel.h"
#include "view/shown_stage.h"
#include "window/window.h"

namespace spheretree::player {
namespace {

std::size_t longest(const std::vector<ReplayedRun>& runs) {
  std::size_t steps = 0;
  for (const ReplayedRun& run : runs) steps = std::max(steps, run.run.steps.size());
  return steps;
}

}  // namespace

ReplayedRun replayedRun(const std::filesystem::path& recording, const std::filesystem::path& scene, builder::Progress& progress) {
  ReplayedRun out;
  RecordedRun run = readRun(recording);
  const std::filesystem::path path = scene.empty() ? sceneOf(run, recording) : scene;
  const runtime::Mode mode = modeOf(run, recording);
  runtime::SceneDescription description = describeScene(path, progress);
  if (run.identity.settings.find("contact=leaves") != std::string::npos) description.contact = runtime::ContactSurface::Leaves;
  const runtime::Scene compiled = compiledScene(description, path);
  out.skin_contact = description.contact == runtime::ContactSurface::Skin;
  out.title = recording.filename().string();
  out.stage = std::make_unique<view::Stage>(stageOf(description, path, out.notes));
  out.bodies = readBodyPaths(path);
  std::optional<TissueMotion> tissue;
  if (run.identity.settings.find("tissue=large") != std::string::npos) tissue.emplace(compiled, TissueMotion::Clock::Replay);
  out.layers = run.identity.layers;
  out.run = shownRun(std::move(run.steps), compiled, mode, out.bodies, tissue ? &*tissue : nullptr);
  if (!out.run.note.empty()) out.notes.push_back(out.run.note);
  return out;
}

Replay::Replay(std::vector<ReplayedRun> runs) : playback(longest(runs)), runs_(std::move(runs)) {
  for (const ReplayedRun& run : runs_) {
    view::Pane& pane = state.panes.emplace_back();
    pane.stage = run.stage.get();
    pane.title = runs_.size() > 1 ? std::string(state.panes.size() == 1 ? "A  " : "B  ") + run.title : "";
    pane.notes = run.notes;
    pane.has_state = true;
    std::uint32_t faults = 0;
    std::vector<view::PlotSample>& samples = samples_.emplace_back();
    std::vector<std::uint32_t>& so_far = faults_.emplace_back();
    for (const RecordedStep& step : run.run.steps) {
      samples.push_back(view::sampleOf(step));
      samples.back().time -= run.run.steps[0].time;  // both begin at the same time
      so_far.push_back(faults |= step.faults);
    }
  }
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    state.panes[k].samples = samples_[k];
    const auto carriers = [this, k](const RecordedStep& step) { return runs_[k].bodies.posesAt(step.time, step.hinges); };
    removals_.emplace_back(*runs_[k].stage, runs_[k].run.steps, carriers);
  }
  state.title = runs_.size() == 1 ? runs_[0].title : "two runs";
  state.limits = {stage().force_limit, std::nullopt, std::nullopt, std::nullopt, 1000.0};
  state.playback = &playback;
  state.hand_source = view::HandSource::File;
}

void Replay::update() {
  for (std::size_t k = 0; k < runs_.size(); ++k) {
    const ShownRun& run = runs_[k].run;
    view::Pane& pane = state.panes[k];
    const std::size_t step = std::min(playback.step(), run.steps.size() - 1);
    pane.state = run.at(step);
    pane.tissue = run.tissueAt(step);
    pane.carriers = runs_[k].bodies.posesAt(pane.state.step.time, pane.state.step.hinges);
    const std::span<const view::PlotSample> samples(samples_[k]);
    pane.figures = figuresOf(run.steps[step], view::stepTimes(view::lastOf(samples.first(step + 1), 2)));
    pane.figures.insert(pane.figures.end(), runs_[k].results.begin(), runs_[k].results.end());
    pane.removal = removals_[k].at(step);
    if (pane.removal) {
      const std::vector<view::FigureLine> figures = cutFigures(run.steps[step], runs_[k].layers);
      pane.figures.insert(pane.figures.begin(), figures.begin(), figures.end());
    }
    pane.lamps = faultLamps(run.steps[step].faults, faults_[k][step]);
  }
}

void showReplay(Replay& replay, const LiveView::Options& options, builder::Progress& progress) {
  view::Window window("haptic-player: " + replay.state.title, options.width, options.height, options.scale);
  replay.state.look = options.look;
  replay.state.look.skin_contact = replay.hasSkinContact();
  replay.state.panels = options.panels;
  replay.state.follow = options.follow;
  view::Viewer viewer(window.gl(), window.interface(), replay.state);
  replay.state.can_capture = true;
  view::Capture capture("replay");
  replay.playback.loops = false;
  replay.playback.play();
  bool has_camera = false;
  while (window.isOpen() && !replay.state.wants_quit) {
    progress.check();
    const double seconds = window.begin();
    replay.update();
    if (!has_camera) {
      const view::Layout layout = view::layoutOf(replay.state, window.width(), window.height(), window.interface().scale());
      replay.state.camera = view::wishedCamera(replay.stage(), replay.state.panes[0].state.step.graphic, options.wish, layout.panes[0]);
      has_camera = true;
    }
    viewer.frame(window.width(), window.height(), window.samples(), seconds, 0);
    replay.state.film = capture.film();
    const std::string captured =
        capture.take(window.gl(), window.width(), window.height(), std::exchange(replay.state.wants_picture, false),
                     std::exchange(replay.state.wants_film, false));
    if (!captured.empty()) {
      replay.state.message = captured;
      tool::say("haptic-player: " + captured);
    }
    window.present();
  }
  if (const std::string film = capture.end(); !film.empty()) tool::say("haptic-player: " + film);
}

void drawReplay(Replay& replay, const PictureSettings& settings, builder::Progress& progress) {
  if (settings.steps.first >= replay.playback.steps())
    throw tool::UsageError("--at " + std::to_string(settings.steps.first) + ": the run has " + std::to_string(replay.playback.steps()) +
                           " steps, and the first is step 0");
  replay.state.look = settings.look;
  replay.state.look.skin_contact = replay.hasSkinContact();
  replay.state.panels = settings.panels;
  replay.state.follow = settings.follow;
  view::PictureMaker maker(settings.width, settings.height, settings.scale, replay.state);
  bool has_camera = false;
  for (std::uint64_t step = settings.steps.first; step <= settings.steps.last && step < replay.playback.steps();
       step += settings.steps.every) {
    progress.check();
    replay.playback.seek(static_cast<double>(step));
    replay.update();
    if (!has_camera)
      replay.state.camera =
          view::wishedCamera(replay.stage(), replay.state.panes[0].state.step.graphic, settings.wish, maker.layout().panes[0]);
    has_camera = true;
    drawPicture(maker, settings, step);
  }
}

}  // namespace spheretree::player
