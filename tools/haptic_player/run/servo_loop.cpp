// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/servo_loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "run/real_time.h"
#include "spheretree/device/real_time_thread.h"

namespace spheretree::player {

ServoLoop::ServoLoop(const runtime::Scene& scene, RecordingWriter* recording, const Options& options, view::LiveStreams* live)
    : scene_(scene),
      recording_(recording),
      options_(options),
      live_(live),
      tuner_(options.tuned && live ? std::optional<SceneTuner>(options.tuned->compiled()) : std::nullopt),
      workspace_(scene),
      statistics_(scene.compiled().step_time),
      mode_(options.mode) {}

device::Rendered ServoLoop::render(const device::DeviceState& state) noexcept {
  using Clock = std::chrono::steady_clock;
  if (options_.real_time_thread && ticks_ == 0) priority_error_.store(device::requestRealTimeThread(), std::memory_order_relaxed);
  begun_.fetch_add(1);
  if (state.restarted) restart();
  if (options_.tissue) tissue_states_ = options_.tissue->take(ticks_, workspace_);  // the solver is not part of a step
  runtime::StageTimes times;
  const double processor_start = threadTime();
  const Clock::time_point start = Clock::now();
  const Configuration tool = options_.mount ? device::toolInWorld(*options_.mount, state.handle) : state.handle;
  if (options_.bodies) {
    const double time = static_cast<double>(ticks_) * scene_.compiled().step_time;
    steerHinges(options_.bodies->anglesAt(time));
    options_.bodies->moveTo(time, hinges_, workspace_);
  }
  if (tuner_) {
    tuner_->tune(live_->settings);
    changeMode();
  }
  if (options_.cuts) turnSpindle(static_cast<double>(ticks_) * scene_.compiled().step_time, state.buttons);
  const runtime::StepResult result = runtime::step(scene_, tool, mode(), workspace_, &times);
  const double total_us = std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  RecordedStep row = recordedStep(ticks_, tool, result, times, total_us, runtime::contacts(workspace_));
  row.time = static_cast<double>(ticks_++) * scene_.compiled().step_time;
  if (options_.cuts) addCut(row);
  row.hinges = hinges_;
  row.tissue_states = tissue_states_;
  row.passivity_force = state.added.force.norm();
  row.passivity_torque = state.added.torque.norm();
  row.passivity_debt = state.debt;
  statistics_.add(row, threadTime() - processor_start);
  force_.store(row.wrench.force.norm(), std::memory_order_relaxed);
  torque_ = row.wrench.torque.norm();
  time_.store(total_us, std::memory_order_relaxed);
  RecordingWriter* const recording = recording_.load();
  if (recording && options_.wait) recording->pushWaiting(row);
  if (recording && !options_.wait) recording->push(row);
  if (live_) publish(row);
  ended_.fetch_add(1);
  const Wrench on_hand = options_.mount ? device::wrenchOnHandle(*options_.mount, state.handle, result.wrench) : result.wrench;
  return {on_hand, 0, (result.faults & runtime::kBadInput) != 0};
}

void ServoLoop::changeMode() noexcept {
  // The modes agree on the wrench only where nothing is touched: below half of what a hand perceives as a difference.
  constexpr double kUnfeltForce = 0.05, kUnfeltTorque = 2.5;  // [N, N mm]
  if (force() > kUnfeltForce || torque_ > kUnfeltTorque) return;
  const runtime::Mode other = options_.mode == runtime::Mode::Published ? runtime::Mode::Constrained : runtime::Mode::Published;
  mode_.store(live_->settings.other_mode.load(std::memory_order_relaxed) ? other : options_.mode, std::memory_order_relaxed);
}

void ServoLoop::turnSpindle(double time, std::uint32_t buttons) noexcept {
  const std::size_t at = static_cast<std::size_t>(std::lround(1000 * time));
  bool turns = options_.spins.empty() || options_.spins[std::min(at, options_.spins.size() - 1)];
  if (options_.spindle_buttons) turns = buttons & options_.spindle_buttons;
  const view::SpindleWish wish = live_ ? live_->spindle.load(std::memory_order_relaxed) : view::SpindleWish::None;
  if (wish != view::SpindleWish::None) turns = wish == view::SpindleWish::On;
  (void)runtime::setSpindle(turns && mode() == runtime::Mode::Constrained, workspace_);  // the method of the paper cuts nothing
}

// Layers are counted through all objects, as the recording names them.
void ServoLoop::addCut(RecordedStep& row) const noexcept {
  row.spins = runtime::turns(workspace_);
  row.removed = 0;
  std::uint32_t first = 0;
  for (std::size_t i = 0; i < scene_.objectCount(); ++i) {
    const runtime::CutState state = runtime::cutState(i, workspace_);
    for (const double volume : state.removed) row.removed += volume;
    if (state.layer != runtime::CutState::kNone) row.layer = first + state.layer;
    first += static_cast<std::uint32_t>(scene_.cutLayers(i));
  }
}

void ServoLoop::restart() noexcept {
  runtime::reset(workspace_);
  runtime::mend(workspace_);
  if (options_.tissue) options_.tissue->restart();
  statistics_.restart();
  ticks_ = 0;
  hinges_ = {};
  is_steered_ = {};
  ++restarts_;
}

void ServoLoop::steerHinges(const HingeAngles& path) noexcept {
  constexpr double kJaw = 60;  // if a slider jumps, a jaw opens at this speed [degree/s]
  const double fastest = kJaw * scene_.compiled().step_time;
  for (std::size_t k = 0; k < kMaxHinges; ++k) {
    const double wish = live_ ? live_->hinges.degree[k].load(std::memory_order_relaxed) : std::numeric_limits<double>::quiet_NaN();
    const bool is_wished = !std::isnan(wish);
    const double goal = is_wished ? wish : path[k];
    is_steered_[k] = is_wished || (is_steered_[k] && hinges_[k] != goal);  // and then back to its path
    hinges_[k] = is_steered_[k] ? std::clamp(goal, hinges_[k] - fastest, hinges_[k] + fastest) : goal;
  }
}

bool ServoLoop::record(RecordingWriter* recording) noexcept {
  recording_.store(recording);
  // A step that begins after this sees the new writer: these operations have the same order for all threads.
  const std::uint64_t begun = begun_.load();
  for (int n = 0; n < 1000 && ended_.load() < begun; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return ended_.load() >= begun;
}

void ServoLoop::publish(const RecordedStep& row) noexcept {
  live_->steps.push(row);
  view::LiveState& state = live_->state.back();
  state.step = row;
  state.restarts = restarts_;
  state.contact_count = 0;
  for (const runtime::Contact& contact : runtime::contacts(workspace_))
    if (state.contact_count < state.contacts.size()) state.contacts[state.contact_count++] = shownContact(contact);
  live_->state.publish();
}

view::ShownContact shownContact(const runtime::Contact& contact) noexcept {
  return {contact.point.cast<float>(), contact.normal.cast<float>(), static_cast<float>(contact.force), contact.friction.cast<float>(),
          contact.object};
}

RecordedStep recordedStep(std::uint64_t tick, const Configuration& haptic, const runtime::StepResult& result,
                          const runtime::StageTimes& times, double total_us, std::span<const runtime::Contact> contacts) noexcept {
  const auto us = [](std::uint64_t ns) { return static_cast<double>(ns) / 1000; };
  Eigen::Vector3d friction = Eigen::Vector3d::Zero();
  const runtime::Contact* strongest = nullptr;
  for (const runtime::Contact& contact : contacts) {
    friction += contact.friction;
    if (!strongest || contact.force > strongest->force) strongest = &contact;
  }
  return {.tick = tick,
          .time = static_cast<double>(tick) / 1000,
          .haptic = haptic,
          .graphic = result.graphic,
          .wrench = result.wrench,
          .pairs = result.pairs,
          .rows = result.rows,
          .active = result.active,
          .qp_iterations = result.qp_iterations,
          .faults = result.faults,
          .find_us = us(times.find),
          .rows_us = us(times.rows),
          .qp_us = us(times.qp),
          .total_us = total_us,
          .penetration = result.penetration,
          .touched = strongest ? strongest->object : kUntouched,
          .friction = friction.norm(),
          .slip = strongest ? strongest->slip.norm() : 0};
}

}  // namespace spheretree::player
