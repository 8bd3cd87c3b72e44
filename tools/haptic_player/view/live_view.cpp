// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/live_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "run/servo_loop.h"
#include "spheretree/device/emergency_stop.h"
#include "spheretree/formats/errors.h"
#include "terminal.h"
#include "view/run_panel.h"
#include "view/shown_stage.h"
#include "view/start_pose.h"

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
    state.hinges.push_back({body.name, "%.1f deg", std::min(body.lowest, middle - half), std::max(body.highest, middle + half)});
  }
  removal_.emplace(stage_);
  for (const view::PlacedObject& object : stage_.objects)
    if (object.cut)
      for (const auto& layer : object.cut->layers) layers_.push_back(layer.name);
  view::Pane pane;
  pane.stage = &stage_;
  pane.removal = removal_->empty() ? nullptr : &*removal_;
  pane.notes = std::move(notes);
  state.panes = {std::move(pane)};
  state.limits = {scene.wrench_limits.force, std::nullopt, std::nullopt, std::nullopt, 1000.0};
}

void RunShown::update(TissueMotion* tissue) {
  view::Pane& shown = pane();
  if (state.frozen && frozen_.empty()) frozen_.assign(shown.samples.begin(), shown.samples.end());
  if (!state.frozen) frozen_.clear();
  streams.steps.drain([&](const RecordedStep& step) {
    history_.add(view::sampleOf(step));
    rumble.add(step.wrench.force, 1e-3);
    faults_so_far_ |= step.faults;
    if (removal_->empty()) return;
    if (step.tick == 0) removal_.emplace(stage_);  // the run began again
    removal_->add(step, bodies_.posesAt(step.time, step.hinges));
  });
  shown.samples = state.frozen ? std::span<const view::PlotSample>(frozen_) : history_.samples();
  shown.has_state = streams.state.refresh() || shown.has_state;
  shown.state = streams.state.front();
  shown.carriers = bodies_.posesAt(shown.state.step.time, shown.state.step.hinges);
  if (tissue) shown.tissue = tissue->shapes();
  const auto pass = [](const view::ValueControl& control, std::atomic<double>& wish) {
    wish.store(control.wish.value_or(std::numeric_limits<double>::quiet_NaN()), std::memory_order_relaxed);
  };
  for (std::size_t k = 0; k < state.hinges.size(); ++k) {
    state.hinges[k].now = shown.state.step.hinges[k];
    pass(state.hinges[k], streams.hinges.degree[k]);
  }
  std::atomic<double>* const settings[] = {&streams.settings.stiffness, &streams.settings.damping, &streams.settings.friction};
  for (std::size_t k = 0; k < state.settings.size(); ++k) pass(state.settings[k], *settings[k]);
  streams.settings.other_mode.store(state.wants_other_mode, std::memory_order_relaxed);
  const std::uint64_t tick = shown.state.step.tick;
  if (shown.state.restarts != restarts_) {
    restarts_ = shown.state.restarts;
    rumble.clear();
    faults_so_far_ = 0;
    times_due_ = 0;
  }
  if (tick >= times_due_) {  // sorting takes a while, so it is done four times a second
    times_ = view::stepTimes(view::lastOf(shown.samples, 10));
    times_due_ = tick + 250;
  }
  shown.figures = figuresOf(shown.state.step, times_);
  if (shown.removal) {
    const std::vector<view::FigureLine> figures = cutFigures(shown.state.step, layers_);
    shown.figures.insert(shown.figures.begin(), figures.begin(), figures.end());
  }
  shown.lamps = faultLamps(shown.state.step.faults, faults_so_far_);
}

LiveView::LiveView(const Options& options, const PlaySettings& settings)
    : options_(options),
      settings_(settings),
      window_("haptic-player", options.width, options.height, options.scale),
      capture_(runName(settings)) {
  if (options.hand == view::HandSource::SpaceMouse) {
    space_mouse_.emplace();
    if (!space_mouse_->isOpen()) throw view::ViewError(space_mouse_->fault());
  }
  if (options.hand == view::HandSource::Gamepad && !window_.gamepad())
    throw view::ViewError("no gamepad was found. Connect one that the desktop supports, or choose another --hand-from");
  first_recording_ = !settings.record.empty();
  if (options.hand == view::HandSource::Gamepad) openRumble();
  rated_ = Clock::now();
}

void LiveView::openRumble() {
  std::uint16_t vendor = 0, product = 0;
  if (view::idsOfGamepad(window_.gamepadIdentity(), vendor, product)) rumble_.emplace(vendor, product);
  const std::string fault = rumble_ ? rumble_->fault() : "no rumble: the gamepad does not say who made it";
  if (!fault.empty()) tool::say("haptic-player: " + fault);
}

LiveView::~LiveView() {
  // The run has ended: there are no more steps.
  if (recording_) try {
      recording_->finish();
    } catch (const formats::FileError& error) {
      tool::say(std::string("haptic-player: ") + error.what());
    }
  if (const std::string film = capture_.end(); !film.empty()) tool::say("haptic-player: " + film);
}

void LiveView::onScene(const runtime::SceneDescription& scene) {
  loaded_ = Clock::now();
  shown_.setScene(scene, settings_.scene);
  view::ViewerState& state = shown_.state;
  state.look = options_.look;
  state.look.skin_contact = settings_.contact == runtime::ContactSurface::Skin;
  state.panels = options_.panels;
  state.follow = options_.follow;
  state.can_record = state.can_capture = state.course.is_live = true;
  state.can_spin = shown_.pane().removal && settings_.mode == runtime::Mode::Constrained;
  addSettings(scene);
  state.hand_source = options_.hand;
  viewer_ = std::make_unique<view::Viewer>(window_.gl(), window_.interface(), state);
}

void LiveView::addSettings(const runtime::SceneDescription& scene) {
  view::ViewerState& state = shown_.state;
  const runtime::Coupling& coupling = scene.coupling;
  const bool is_real = settings_.device == DeviceKind::Real;  // which is stable up to some stiffness: that of the scene is known to work
  state.settings = {
      {"stiffness", "%.2f N/mm", 0.1 * coupling.translation, (is_real ? 1 : 3) * coupling.translation, coupling.translation},
      {"damping", "%.4f N s/mm", 0, std::max(0.004 * coupling.translation, (is_real ? 1 : 2) * coupling.damping), coupling.damping}};
  double friction = scene.tool_friction;
  bool has_tissue = false;
  for (const runtime::SceneObject& object : scene.objects) {
    friction = std::max(friction, object.friction);
    has_tissue = has_tissue || object.tissue;
  }
  state.settings.push_back({"friction", "%.2f", 0, std::max(1.0, friction), friction});
  if (has_tissue) return;  // the published method does not know it
  state.modes = {"constrained", "paper"};
  if (settings_.mode == runtime::Mode::Published) std::swap(state.modes[0], state.modes[1]);
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
  return [driven, start, &streams](double time) {
    if (time < driven->time) {  // the run began again
      driven->filter.resetTo(start);
      driven->target = start;
      driven->time = time;
    }
    if (streams.hand.refresh() && streams.hand.front().is_set) driven->target = streams.hand.front().pose;
    const double seconds = std::clamp(time - driven->time, 0.0, 0.01);  // limited, so that a late step does not cause a jump
    driven->time = time;
    return driven->filter.towards(driven->target, seconds);
  };
}

device::IntendedPath LiveView::handPath(device::IntendedPath path) {
  start_ = path(0);
  const auto over_tooth = startOverTooth(shown_.stage());
  if (over_tooth && settings_.trajectory.empty() && options_.hand != view::HandSource::File) {
    start_ = over_tooth->pose;
    shown_.state.press_here = over_tooth->crown;
  }
  hand_.resetTo(start_);
  if (options_.hand == view::HandSource::File) return path;
  shown_.streams.spindle = view::SpindleWish::Off;  // until the user starts it
  shown_.state.hand = &hand_;
  return drivenPath(shown_.streams, start_);
}

void LiveView::steer(double seconds) {
  if (!shown_.state.hand) return;
  if (shown_.pane().state.restarts < asked_restarts_) {  // the tool is not yet back at the start
    hand_.resetTo(start_);
    shown_.streams.hand.publish({start_, true});
    return;
  }
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

void LiveView::turnSpindle() {
  bool asks = std::exchange(shown_.state.wants_spindle, false);
  if (options_.hand == view::HandSource::Gamepad) {
    const auto pad = window_.gamepad();
    const bool is_held = pad && pad->button;
    asks = asks || (is_held && !pad_button_);
    pad_button_ = is_held;
  }
  if (space_mouse_ && space_mouse_->takePress()) asks = true;
  if (asks && shown_.state.can_spin)
    shown_.streams.spindle = shown_.pane().state.step.spins ? view::SpindleWish::Off : view::SpindleWish::On;
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
  const view::RunCourse& course = shown_.state.course;
  const std::string rate = course.is_paused ? "paused" : grouped(static_cast<std::uint64_t>(rate_ + 0.5)) + " Hz";
  pane.figures.insert(pane.figures.begin(), {{"rate", rate, !course.is_paused && rate_ < 950.0 / course.slowness},
                                             {"late steps", grouped(status.late_ticks) + " of " + grouped(status.ticks),
                                              status.late_ticks * 1000 > status.ticks}});
  if (const std::uint64_t lost = shown_.streams.steps.lost()) pane.figures.push_back({"steps not shown", grouped(lost), true});
  const std::vector<view::Lamp> safety = safetyLamps(status.safety, status.safety_so_far);
  pane.lamps.insert(pane.lamps.end(), safety.begin(), safety.end());
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
  const std::filesystem::path name = view::freeName(runName(settings_), ".csv");
  PlaySettings now = settings_;
  now.mode = loop.mode();
  recording_ = std::make_unique<RecordingWriter>(name, identityOf(now, name, loop.tissue() != nullptr));
  (void)loop.record(recording_.get());
  state.message.clear();
} catch (const formats::FileError& error) {
  shown_.state.message = error.what();
  (void)loop.record(nullptr);
  recording_.reset();
}

void LiveView::setCourse(device::Device& device, ServoLoop& loop) {
  view::ViewerState& state = shown_.state;
  view::RunCourse& course = state.course;
  constexpr const char* kOwnClock = "is not for a real device: a hand holds its arm, and cannot be slowed down or put back";
  const std::uint32_t pace = course.is_paused ? 0 : static_cast<std::uint32_t>(course.slowness);
  if (pace != pace_) {
    if (device.setPace(pace)) {
      pace_ = pace;
    } else {
      course.slowness = 1;
      state.message = std::string("slow motion ") + kOwnClock;
    }
  }
  for (; course.wanted_steps > 0; --course.wanted_steps)
    if (!device.stepOnce()) state.message = std::string("a single step ") + kOwnClock;
  const bool is_restarting = shown_.pane().state.restarts < asked_restarts_;
  if (std::exchange(course.wants_restart, false) && !is_restarting) {
    if (recording_ || first_recording_) toggleRecording(loop);  // a recording is of one run
    ++asked_restarts_;
    for (view::ValueControl& hinge : state.hinges) hinge.wish.reset();
    steer(0);
    if (!device.restart()) {
      --asked_restarts_;
      state.message = std::string("a reset ") + kOwnClock;
    }
  }
}

bool LiveView::onTurn(device::Device& device, ServoLoop& loop) {
  const device::DeviceStatus status = device.status();
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
    state.camera = view::wishedCamera(shown_.stage(), shown_.pane().state.step.graphic, options_.wish, layout.panes[0]);
    has_camera_ = true;
  }
  if (shown_.pane().state.contact_count > 0) state.press_here.reset();
  showStatus(status);
  state.film = capture_.film();
  state.is_other_mode = loop.mode() != settings_.mode;
  state.recording = recording_ ? recording_->path().string() : first_recording_ ? settings_.record.string() : "";
  viewer_->frame(window_.width(), window_.height(), window_.samples(), seconds, 0);
  const std::string captured = capture_.take(window_.gl(), window_.width(), window_.height(), std::exchange(state.wants_picture, false),
                                             std::exchange(state.wants_film, false));
  if (!captured.empty()) {
    state.message = captured;
    tool::say("haptic-player: " + captured);
  }
  window_.present();
  const Clock::time_point shown = Clock::now();
  if (frames_.count() == 0) first_frame_ = std::chrono::duration<double>(shown - loaded_).count();
  frames_.add(std::chrono::duration<double, std::micro>(shown - begun).count());
  if (rumble_) rumble_->set(state.course.is_paused || state.frozen ? view::RumbleStrength() : shown_.rumble.strength());
  setCourse(device, loop);
  steer(seconds);
  turnSpindle();
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
