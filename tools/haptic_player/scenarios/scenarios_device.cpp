// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of moving objects, and of the device's safety rules. Distances in mm, speeds in mm/s.
#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "scenarios/scenario_run.h"
#include "spheretree/device/simulated_device.h"

namespace spheretree::player {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// F9: rows that contradict each other.
Outcome squeezed(ScenarioContext& context, Mode mode) {
  Outcome out;
  // A slot closes around a cylinder of diameter 10 from a width of 14 to 9.8 and opens again, at 1 mm/s.
  const Body &cylinder = context.bodies.get("cylinder"), &wall = context.bodies.get("wall");
  const Configuration left{{-7, 0, 0}, kUpright}, right{{7, 0, 0}, rotationOf({0, 0, std::numbers::pi})};
  ScenarioRun slot(cylinder, {{&wall, left}, {&wall, right}}, mode);
  double beyond_half = 0, force = 0;
  int unanswered = 0, unlogged = 0, steps_inside = 0;
  const auto squeeze = [&](double way, int steps) {
    for (int n = 0; n < steps; ++n) {
      slot.moveObject(0, {way, 0, 0});
      slot.moveObject(1, {-way, 0, 0});
      const runtime::StepResult r = slot.to({{0.3, 0, 0}, kUpright});
      unanswered += !isFinite(r.graphic);
      force = std::max(force, r.limited_wrench.force.norm());
      if (n % 10) continue;
      const double a = slot.leafDepth(r.graphic, 0), b = slot.leafDepth(r.graphic, 1);
      beyond_half = std::max(beyond_half, std::max(a, b) - 0.5 * (a + b));
      unlogged += std::max(a, b) > 2 * runtime::kGapTolerance && !(r.faults & (runtime::kPenetrating | runtime::kRowsConflict));
    }
  };
  squeeze(0.0005, 4200);
  squeeze(-0.0005, 4200);
  for (int n = 0; n < 100 && slot.leafDepth(slot.last().graphic) > kPenetrationPass; ++n, ++steps_inside) slot.to({{0.3, 0, 0}, kUpright});
  // A block jumps by 2 into a ball that rests on it.
  const Body &ball = context.bodies.get("ball"), &block = context.bodies.get("block");
  ScenarioRun jump(ball, {{&block, {}}}, mode);
  jump.to({{0, 0, 8}, kUpright});
  jump.moveTo({0, 0, 5}, 50);
  jump.moveObject(0, {0, 0, 2});
  int recovery = 0;
  for (; recovery < 100; ++recovery) {
    const runtime::StepResult r = jump.to({{0, 0, 5}, kUpright});
    unanswered += !isFinite(r.graphic);
    force = std::max(force, r.limited_wrench.force.norm());
    if (jump.leafDepth(r.graphic) <= kPenetrationPass) break;
  }
  out.add("steps without an answer", "1", unanswered, 0);
  out.add("penetration beyond half of the forced overlap", "mm", beyond_half, kPenetrationPass);
  out.add("force after the limit", "N", force, 8 + 1e-9);
  out.add("steps inside that no fault bit reports", "1", unlogged, 0);
  out.add("time to come out once the slot is open", "ms", steps_inside, 50);
  out.add("time to come out of a block that jumped 2 mm", "ms", recovery, 50);
  slot.finish(out);
  return out;
}

// F19 to F21 test the safety rules between runtime and device: both modes are equal except for the incoming wrench.
struct ScriptedRenderer final : device::Renderer {
  std::function<device::Rendered(const device::DeviceState&)> answer;
  device::Rendered render(const device::DeviceState& state) noexcept override { return answer(state); }
};

Outcome startInContact(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &ball = context.bodies.get("ball"), &slab = context.bodies.get("slab");
  ScenarioRun trial(ball, {{&slab, {}}}, mode);
  device::Safety safety;
  Wrench last;
  std::uint64_t tick = 0;
  double largest_step = 0;
  const auto drive = [&](double z) {
    device::DeviceState state;
    state.tick = tick;
    state.time = static_cast<double>(tick++) / 1000;
    state.handle = {{0, 0, z}, kUpright};
    const Wrench sent = safety.limit(state, {trial.to(state.handle).wrench, 0, false});
    largest_step = std::max(largest_step, (sent.force - last.force).norm());
    last = sent;
    return sent.force.norm();
  };
  trial.resetTo({{0, 0, 8}, kUpright});  // the graphic tool starts outside, the hand 10 deep
  double early = 0, after_jump = 0, z = -5;
  while (tick < 500) early = std::max(early, drive(z));
  while (tick < 3000) drive(z = std::min(10.0, z + 0.02));
  for (int n = 0; n < 200; ++n) after_jump = std::max(after_jump, drive(z - 20));  // recalibrated in free space: suddenly 20 mm deeper
  while (tick < 6000) drive(z = std::max(4.0, z - 0.02));
  const double quiet_step = std::exchange(largest_step, 0.0), pressed = last.force.norm();
  for (int n = 0; n < 200; ++n) after_jump = std::max(after_jump, drive(z - 20));  // the same while it presses
  out.add("force before the guard opens", "N", early, 0);
  out.add("largest step of the force, started or calibrated in contact", "N", quiet_step, 0.05);
  out.add("largest step, calibrated while it presses", "N", largest_step, 0.05);
  out.add("force while a calibration jump lasts", "N", after_jump, 0);
  out.note = "A pose that jumps while the hand presses, here with " + text(pressed) +
             " N, cannot be trusted. The safety rules then require zero force within two steps, so the force drops by its full value.";
  trial.finish(out);
  return out;
}

Outcome overrun(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &ball = context.bodies.get("ball"), &slab = context.bodies.get("slab");
  double resume_step = 0, left = 0;
  for (const int pause : {5, 20, 200, 500}) {  // ms without a new result
    ScenarioRun trial(ball, {{&slab, {}}}, mode);
    device::SafetySettings settings;
    settings.start_guard = false;
    device::Safety safety(settings);
    Wrench last, model;
    double age = 0;
    bool fresh = true;
    for (int n = 0; n < 4000 + pause + 300; ++n) {
      device::DeviceState state;
      state.tick = static_cast<std::uint64_t>(n);
      state.time = n / 1000.0;
      state.handle = {{0, 0, std::max(4.0, 8 - 0.005 * n)}, kUpright};
      fresh = n < 4000 || n >= 4000 + pause;
      if (fresh) model = trial.to(state.handle).wrench, age = 0;
      if (!fresh) age += 0.001;
      const Wrench sent = safety.limit(state, {model, age, false});
      if (n >= 4000 + pause) resume_step = std::max(resume_step, sent.force.norm() - last.force.norm());
      if (n == 4000 + pause - 1 && pause >= 200) left = std::max(left, sent.force.norm());
      last = sent;
    }
    if (pause == 200) trial.finish(out);
  }
  out.add("force step on resume", "N", resume_step, 0.1);
  out.add("force after 200 ms without a fresh model", "N", left, 0);
  return out;
}

Outcome saturation(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &cube = context.bodies.get("cube"), &block = context.bodies.get("block");
  ScenarioRun trial(cube, {{&block, {}}}, mode);
  trial.to({{0, 0, 14}, kUpright});
  trial.moveTo({4, 0, -50}, 200);
  for (int n = 0; n < 90; ++n) trial.to({{4, 0, -50}, rotationOf({0, 0, n * kDegree})});
  device::SafetySettings settings;
  settings.start_guard = false;
  settings.max_force = 22;
  settings.max_torque = {515, 515, 170};
  settings.ramp = 0.001;
  settings.force_slew = settings.torque_slew = settings.ramp_force_slew = settings.ramp_torque_slew = 1e6;
  settings.fade_force = 1e6;
  settings.pose_jump = 1e6;
  device::Safety safety(settings);
  double turned = 0, force = 0, torque = 0;
  std::uint64_t tick = 0;
  for (const RecordedStep& row : trial.rows()) {
    device::DeviceState state;
    state.tick = tick;
    state.time = static_cast<double>(tick++) / 1000;
    state.handle = row.haptic;
    const Wrench sent = safety.limit(state, {row.wrench, 0, false});
    force = std::max(force, sent.force.norm());
    const Eigen::Vector3d in_handle = row.haptic.orientation.conjugate() * sent.torque;
    torque = std::max(torque, in_handle.cwiseAbs().cwiseQuotient(Eigen::Vector3d(515, 515, 170)).maxCoeff());
    if (sent.force.norm() > 1 && row.wrench.force.norm() > 1)
      turned = std::max(turned, std::acos(std::clamp(sent.force.normalized().dot(row.wrench.force.normalized()), -1.0, 1.0)) / kDegree);
  }
  // Moves out slowly, fast and in one step: measures how long a force remains after the haptic tool is free.
  int late = 0;
  for (const double speed : {200.0, 1000.0, 2000.0, 80'000.0}) {
    trial.moveTo({4, 0, -50}, 200);
    int run = 0;
    for (double z = -50; z < 30;) {
      z = std::min(30.0, z + speed / 1000);
      const runtime::StepResult r = trial.to({{4, 0, z}, rotationOf({0, 0, 89 * kDegree})});
      const bool is_free = trial.leafDepth(trial.last().haptic) == 0;
      run = is_free && r.wrench.force.norm() > 1e-6 ? run + 1 : 0;
      late = std::max(late, run);
    }
    for (int n = 0; n < 20 && trial.last().wrench.force.norm() > 1e-6; ++n, late = std::max(late, run)) {
      trial.to(trial.last().haptic);
      ++run;
    }
  }
  out.add("force sent", "N", force, 22 + 1e-9);
  out.add("torque sent over its limits", "1", torque, 1 + 1e-9);
  out.add("turn of the force by the clamp", "degree", turned, 1e-3);
  out.add("cycles by which the force outlasts the contact", "1", late, 1);
  trial.finish(out);
  return out;
}

}  // namespace

std::vector<Scenario> deviceScenarios() {
  return {{"F9", "squeezed", "Rows without a common solution", squeezed, false},
          {"F19", "start", "Start and calibration in contact", startInContact, false},
          {"F20", "overrun", "Overrun and lost updates", overrun, false},
          {"F21", "saturation", "Saturation", saturation, false}};
}

}  // namespace spheretree::player
