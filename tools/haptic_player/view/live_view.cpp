// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/live_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "run/servo_loop.h"
#include "spheretree/device/emergency_stop.h"
#include "spheretree/formats/errors.h"
#include "view/run_panel.h"
#include "view/shown_stage.h"

namespace spheretree::player {

void RunShown::setScene(const runtime::SceneDescription& scene, const std::filesystem::path& path) {
  std::vector<std::string> notes;
  stage_ = stageOf(scene, path, notes);
  state.title = path.empty()                      ? "built-in scene"
                : path.filename() == "scene.json" ? path.parent_path().filename().string() + "/scene.json"
                                                  : path.filename().string();
  bodies_ = readBodyPaths(path);
  for (const BodyPaths::HingedBody& body : bodies_.hinged()) {
    constexpr double kMinRange = 20;  // [degree]: a body that rests on its path can also be rotated
    const double middle = (body.lowest + body.highest) / 2, half = std::max(kMinRange, body.highest - body.lowest) / 2;
    state.hinges.push_back({body.name, std::min(body.lowest, middle - half), std::max(body.highest, middle + half), 0, {}});
  }
  view::Pane pane;
  pane.stage = &stage_;
  pane.notes = std::move(notes);
  state.panes = {std::move(pane)};
  state.limits = {scene.wrench_limits.force, std::nullopt, std::nullopt, std::nullopt, 1000.0};
}

void RunShown::update(TissueMotion* tissue) {
  view::Pane& shown = pane();
  if (!state.frozen) {
    streams.steps.drain([&](const RecordedStep& step) {
      history_.add(view::sampleOf(step));
      faults_so_far_ |= step.faults;
    });
    shown.samples = history_.samples();
  }
  shown.has_state = streams.state.refresh() || shown.has_state;
  shown.state = streams.state.front();
  shown.carriers = bodies_.posesAt(shown.state.step.time, shown.state.step.hinges);
  if (tissue) shown.tissue = tissue->shapes();
  for (std::size_t k = 0; k < state.hinges.size(); ++k) {
    state.hinges[k].now = shown.state.step.hinges[k];
    streams.hinges.degree[k].store(state.hinges[k].wish.value_or(std::numeric_limits<double>::quiet_NaN()), std::memory_order_relaxed);
  }
  const std::uint64_t tick = shown.state.step.tick;
  if (tick >= times_due_) {  // sorting takes a while, so it is done four times a second
    times_ = view::stepTimes(view::lastOf(shown.samples, 10));
    times_due_ = tick + 250;
  }
  shown.figures = figuresOf(shown.state.step, times_);
  shown.lamps = faultLamps(shown.state.step.faults, faults_so_far_);
}

LiveView::LiveView(const Options& options, const PlaySettings& settings)
    : options_(options), settings_(settings), window_("haptic-player", options.width, options.height, options.scale) {
  if (options.hand == view::HandSource::SpaceMouse) {
    space_mouse_.emplace();
    if (!space_mouse_->isOpen()) throw view::ViewError(space_mouse_->fault());
  }
  if (options.hand == view::HandSource::Gamepad && !window_.gamepad())
    throw view::ViewError("no gamepad was found. Connect one that the desktop supports, or choose another --hand-from");
  first_recording_ = !settings.record.empty();
  rated_ = Clock::now();
}

LiveView::~LiveView() {
  // The run has ended: there are no more steps.
  if (recording_) try {
      recording_->finish();
    } catch (const formats::FileError& error) {
      std::fprintf(stderr, "haptic-player: %s\n", error.what());
    }
}

void LiveView::onScene(const runtime::SceneDescription& scene) {
  loaded_ = Clock::now();
  shown_.setScene(scene, settings_.scene);
  view::ViewerState& state = shown_.state;
  state.look = options_.look;
  state.look.skin_contact = settings_.contact == runtime::ContactSurface::Skin;
  state.panels = options_.panels;
  state.follow = options_.follow;
  state.can_record = true;
  state.hand_source = options_.hand;
  viewer_ = std::make_unique<view::Viewer>(window_.gl(), window_.interface(), state);
}

device::IntendedPath drivenPath(view::LiveStreams& streams, const Configuration& start) {
  struct Driven {
    view::HandFilter filter;
    Configuration target;
    double time = 0;
  };
  auto driven = std::make_shared<Driven>();
  driven->filter.resetTo(start);
  driven->target = start;
  return [driven, &streams](double time) {
    if (streams.hand.refresh() && streams.hand.front().is_set) driven->target = streams.hand.front().pose;
    const double seconds = std::clamp(time - driven->time, 0.0, 0.01);  // limited, so that a late step does not cause a jump
    driven->time = time;
    return driven->filter.towards(driven->target, seconds);
  };
}

device::IntendedPath LiveView::handPath(device::IntendedPath path) {
  start_ = path(0);
  hand_.resetTo(start_);
  if (options_.hand == view::HandSource::File) return path;
  shown_.state.hand = &hand_;
  return drivenPath(shown_.streams, start_);
}

void LiveView::steer(double seconds) {
  if (!shown_.state.hand) return;
  if (options_.hand == view::HandSource::Gamepad)
    if (const auto pad = window_.gamepad()) hand_.steer(view::gamepadDeflection(pad->axes, pad->bumper), seconds, shown_.state.camera);
  if (space_mouse_) hand_.steer(view::spaceMouseDeflection(space_mouse_->poll()), seconds, shown_.state.camera);
  // The target of the hand must stay near the hand, like the end of a spring.
  const Eigen::Vector3d ahead = hand_.pose().position - shown_.pane().state.step.haptic.position;
  constexpr double kFarthest = 15;  // [mm]
  if (shown_.pane().has_state && ahead.norm() > kFarthest)
    hand_.resetTo({shown_.pane().state.step.haptic.position + ahead.normalized() * kFarthest, hand_.pose().orientation});
  shown_.streams.hand.publish({hand_.pose(), true});
}

void LiveView::showStatus(const device::DeviceStatus& status) {
  const Clock::time_point now = Clock::now();
  const double since = std::chrono::duration<double>(now - rated_).count();
  if (since > 0.5) {
    rate_ = static_cast<double>(status.ticks - rated_ticks_) / since;
    rated_ = now;
    rated_ticks_ = status.ticks;
  }
  view::Pane& pane = shown_.pane();
  pane.figures.insert(pane.figures.begin(), {{"rate", grouped(static_cast<std::uint64_t>(rate_ + 0.5)) + " Hz", rate_ < 950},
                                             {"late steps", grouped(status.late_ticks) + " of " + grouped(status.ticks),
                                              status.late_ticks * 1000 > status.ticks}});
  if (const std::uint64_t lost = shown_.streams.steps.lost()) pane.figures.push_back({"steps not shown", grouped(lost), true});
  const std::vector<view::Lamp> safety = safetyLamps(status.safety, status.safety_so_far);
  pane.lamps.insert(pane.lamps.end(), safety.begin(), safety.end());
}

std::filesystem::path LiveView::nextRecording() const {
  const std::filesystem::path base = settings_.record.empty() ? std::filesystem::path("run.csv") : settings_.record;
  for (int n = 1;; ++n) {
    std::filesystem::path name = base;
    name.replace_filename(base.stem().string() + "-" + std::to_string(n) + ".csv");
    if (!std::filesystem::exists(name)) return name;
  }
}

void LiveView::toggleRecording(ServoLoop& loop) try {
  view::ViewerState& state = shown_.state;
  if (recording_ || first_recording_) {
    (void)loop.record(nullptr);
    if (recording_) recording_->finish();
    state.message = "recorded: " + (recording_ ? recording_->path() : settings_.record).string();
    recording_.reset();
    first_recording_ = false;
    return;
  }
  const std::filesystem::path name = nextRecording();
  recording_ = std::make_unique<RecordingWriter>(name, identityOf(settings_, name, loop.tissue() != nullptr));
  (void)loop.record(recording_.get());
  state.message.clear();
} catch (const formats::FileError& error) {
  shown_.state.message = error.what();
  (void)loop.record(nullptr);
  recording_.reset();
}

bool LiveView::onTurn(const device::DeviceStatus& status, ServoLoop& loop) {
  view::ViewerState& state = shown_.state;
  if (!window_.isOpen() || state.wants_quit) {
    // As an emergency stop: zero from the next step on. The device then reports that it has stopped, and the run ends.
    if (!stop_asked_) device::EmergencyStop::request();
    stop_asked_ = true;
    if (recording_) toggleRecording(loop);
    return status.phase == device::Phase::Running;
  }
  const double seconds = window_.begin();
  const Clock::time_point begun = Clock::now();
  shown_.update(loop.tissue());
  if (!has_camera_ && shown_.pane().has_state) {
    const view::Layout layout = view::layoutOf(state, window_.width(), window_.height(), window_.interface().scale());
    state.camera = view::wishedCamera(shown_.stage(), shown_.pane().state.step.graphic.position, options_.wish, layout.panes[0]);
    has_camera_ = true;
  }
  showStatus(status);
  state.recording = recording_ ? recording_->path().string() : first_recording_ ? settings_.record.string() : "";
  viewer_->frame(window_.width(), window_.height(), window_.samples(), seconds, 0);
  window_.present();
  const Clock::time_point shown = Clock::now();
  if (frames_.count() == 0) first_frame_ = std::chrono::duration<double>(shown - loaded_).count();
  frames_.add(std::chrono::duration<double, std::micro>(shown - begun).count());
  steer(seconds);
  if (std::exchange(state.wants_record, false)) toggleRecording(loop);
  return true;
}

void LiveView::addTo(nlohmann::ordered_json& summary) const {
  summary["view"] = {{"frames", frames_.count()},
                     {"frame_us", timesJson(frames_)},
                     {"first_frame_s", std::round(first_frame_ * 1000) / 1000},
                     {"steps_not_shown", shown_.streams.steps.lost()}};
}

}  // namespace spheretree::player
