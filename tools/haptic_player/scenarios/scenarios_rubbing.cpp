// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of friction and of moving bodies. Distances in mm, speeds in mm/s. The mode of the paper and the published
// renderers have no friction: their friction figures are reported but not judged.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenarios/scenario_run.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;
constexpr double radians(double degree) { return degree * std::numbers::pi / 180; }

ScenarioRun::Options rubbing(double friction) {
  ScenarioRun::Options options;
  options.friction = friction;
  return options;
}

/// Moves down from `from` until the tool presses with 1 N. Returns the height of the hand then.
double pressed(ScenarioRun& trial, const Vector3d& from) {
  Vector3d at = from;
  for (int n = 0; n < 20'000 && trial.last().wrench.force.z() < 1; ++n) trial.to({at -= Vector3d(0, 0, 0.005), kUpright});
  return at.z();
}

/// F23: a drag that starts, stops and reverses. The hand's motion is smooth, so that a jump of the force is the
/// renderer's own stick-slip.
Outcome stickSlip(ScenarioContext& context, Mode mode) {
  Outcome out;
  double jump = 0, off = 0, deepest = 0;
  for (const double speed : {1.0, 5.0, 20.0}) {
    ScenarioRun trial(context.bodies.get("ball"), {{&context.bodies.get("slab"), {}}}, mode, rubbing(0.3));
    trial.to({{0, 0, 8}, kUpright});
    const double z = pressed(trial, {0, 0, 8});
    const int steps = static_cast<int>(4000 / std::sqrt(speed));
    Vector3d at(0, 0, z), last = trial.last().wrench.force;
    for (int n = 0; n < steps; ++n) {
      const double now = speed * std::sin(2 * std::numbers::pi * n / 1000);  // forth and back in a second
      at.x() += now / 1000;
      const Vector3d force = trial.to({at, kUpright}).wrench.force;
      jump = std::max(jump, (force - last).norm() - std::abs(now) / 1000);  // 1 N/mm: the part that the hand explains
      last = force;
      // After the hand has moved far enough in one direction, the tool slides: mu N against the motion.
      if (n % 500 == 250 && speed > 3) off = std::max(off, std::abs(force.head<2>().norm() / force.z() / 0.3 - 1));
    }
    deepest = std::max(deepest, trial.leafPenetration());
    if (speed == 20.0) trial.finish(out);
  }
  out.add("largest step of the force beyond the hand's own", "N", jump, 0.005);
  out.add("drag off mu N", "%", 100 * off, 1);
  out.figures.back().informative = mode != Mode::Constrained;
  out.add("penetration of leaf spheres", "mm", deepest, kPenetrationPass);
  return out;
}

/// F24: a tool that friction holds on slopes, for a minute, with a trembling hand.
Outcome creep(ScenarioContext& context, Mode mode) {
  Outcome out;
  double drift = 0, slid = 1e9;
  const int steps = context.repetitions(60'000, 3000);
  for (const double slope : {radians(5), radians(12)}) {
    const Quaternion turn = rotationOf({0, slope, 0});
    ScenarioRun trial(context.bodies.get("ball"), {{&context.bodies.get("slab"), {Vector3d::Zero(), turn}}}, mode, rubbing(0.2));
    trial.to({turn * Vector3d(0, 0, 8), turn});
    Random random(24);
    Vector3d at = turn * Vector3d(0, 0, 8);
    for (int n = 0; n < 2000 && trial.last().wrench.force.norm() < 1; ++n) trial.to({at -= Vector3d(0, 0, 0.005), turn});
    for (int n = 0; n < 200; ++n) trial.to({at, turn});
    const Vector3d start = trial.last().graphic.position;
    for (int n = 0; n < steps; ++n) {
      const Vector3d tremor(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      trial.to({at + 0.002 * tremor, turn});
    }
    for (int n = 0; n < 200; ++n) trial.to({at, turn});
    const Vector3d way = turn.conjugate() * (trial.last().graphic.position - start);
    if (slope < 0.1) drift = way.head<2>().norm();
    const Vector3d force = turn.conjugate() * trial.last().wrench.force;
    if (slope > 0.1) slid = force.head<2>().norm() / force.z();  // it has slid until the cone holds it
    if (slope < 0.1) trial.finish(out);
  }
  out.add("drift on a slope of 5 degrees in a minute", "mm", drift, 1e-4);
  out.add("tangent of the force on 12 degrees", "1", slid, 0.2 * 1.01);
  return out;
}

/// F25: two blocks close on a ball at 50 mm/s, to 1 mm less than its diameter, and open.
Outcome crush(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &ball = context.bodies.get("ball"), &block = context.bodies.get("block");
  ScenarioRun::Options options;
  options.moving = true;
  ScenarioRun trial(ball, {{&block, {{0, 0, -6}, kUpright}}, {&block, {{0, 0, 6}, rotationOf({std::numbers::pi, 0, 0})}}}, mode, options);
  trial.to({{0, 0, 0.4}, kUpright});
  double way = 0, force = 0, free_depth = 0, beyond_half = 0;
  int unanswered = 0, unlogged = 0, recovery = 0;
  const auto go = [&](double by, int steps) {
    for (int n = 0; n < steps; ++n) {
      trial.carryObject(0, {0, 0, by});
      trial.carryObject(1, {0, 0, -by});
      way += by;
      const runtime::StepResult r = trial.to({{0, 0, 0.4}, kUpright});
      unanswered += !isFinite(r.graphic);
      force = std::max(force, r.limited_wrench.force.norm());
      const double a = trial.leafDepth(r.graphic, 0), b = trial.leafDepth(r.graphic, 1), both = a + b;
      if (r.faults == 0) free_depth = std::max(free_depth, std::max(a, b));
      beyond_half = std::max(beyond_half, std::max(a, b) - 0.5 * both);
      unlogged += std::max(a, b) > kPenetrationPass && !(r.faults & (runtime::kPenetrating | runtime::kRowsConflict));
    }
  };
  int closing = 0;
  while (closing < 400 && (trial.leafDepth(trial.last().graphic, 0) + trial.leafDepth(trial.last().graphic, 1)) < 1) go(0.05, 1), ++closing;
  go(-0.05, closing);
  for (; recovery < 100 && trial.leafDepth(trial.last().graphic) > kPenetrationPass; ++recovery) trial.to({{0, 0, 0.4}, kUpright});
  out.add("steps without an answer", "1", unanswered, 0);
  out.add("penetration while no fault bit is set", "mm", free_depth, kPenetrationPass);
  out.add("penetration beyond half of the forced overlap", "mm", beyond_half, 0.05);
  out.add("force after the limit", "N", force, 8 + 1e-9);
  out.add("steps inside that no fault bit reports", "1", unlogged, 0);
  out.add("time to come out once they are open", "ms", recovery, 50);
  trial.finish(out);
  return out;
}

/// F26: a hand presses a ball on a block, below another block. Both vibrate by 0.2 mm, at 90 and at 110 Hz: the ball
/// leaves the lower one and lands on it, and the upper one comes within 0.04 mm of it.
Outcome chatter(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &ball = context.bodies.get("ball"), &block = context.bodies.get("block");
  constexpr double kShake = 0.2;
  const double away = 5.02 + kShake + leafOverhang(ball);
  ScenarioRun::Options options;
  options.moving = true;
  options.friction = 0.2;
  ScenarioRun trial(ball, {{&block, {{0, 0, -away}, kUpright}}, {&block, {{0, 0, away}, rotationOf({std::numbers::pi, 0, 0})}}}, mode,
                    options);
  trial.to({{0, 0, 0}, kUpright});
  const Vector3d hand(0, 0, 4.92 - away);  // 0.1 mm into the lower one at the middle of its motion
  trial.moveTo(hand, 10);
  double jump = 0, last_height[2] = {0, 0};
  Vector3d last = trial.last().wrench.force;
  const int steps = context.repetitions(5000, 500);
  for (int n = 1; n <= steps; ++n) {
    double moved_by = 0;
    for (std::size_t k = 0; k < 2; ++k) {
      const double height = kShake * std::sin(2 * std::numbers::pi * (k == 0 ? 90 : 110) * n / 1000), by = height - last_height[k];
      trial.carryObject(k, {0, 0, by});
      last_height[k] = height;
      moved_by = std::max(moved_by, std::abs(by));
    }
    const Vector3d force = trial.to({hand, kUpright}).wrench.force;
    jump = std::max(jump, (force - last).norm() - moved_by);  // 1 N/mm: the part that the bodies explain
    last = force;
  }
  out.add("step of the force beyond the bodies' own", "N", jump, 0.05);
  out.add("penetration of leaf spheres", "mm", trial.leafPenetration(), kPenetrationPass);
  trial.finish(out);
  return out;
}

/// F27: a block moves by up to 20 mm within a step, through the position of the ball. The ball is pushed ahead. A body
/// that would use up the work of a step continues in the next steps, and sets a fault bit.
Outcome jumpingBody(ScenarioContext& context, Mode mode) {
  Outcome out;
  int through = 0;
  double deepest = 0, force = 0;
  Random random(27);
  const int runs = context.repetitions(500, 20);
  for (int run = 0; run < runs; ++run) {
    context.progress.check();
    ScenarioRun::Options options;
    options.moving = true;
    options.keep_rows = run == 0;
    ScenarioRun trial(context.bodies.get("ball"), {{&context.bodies.get("slab"), {{0, 0, -30}, kUpright}}}, mode, options);
    const Vector3d hand(random.uniform(-5, 5), random.uniform(-5, 5), 0);
    trial.to({hand, kUpright});
    double height = -30;
    while (height < 10) {
      const double by = random.uniform(5, 20);
      height += by;
      trial.carryObject(0, {random.uniform(-1, 1), random.uniform(-1, 1), by});
      for (int n = 0; n < 10; ++n) {
        const runtime::StepResult r = trial.to({hand, kUpright});
        force = std::max(force, r.limited_wrench.force.norm());
      }
      deepest = std::max(deepest, trial.leafDepth(trial.last().graphic));
    }
    through += trial.last().graphic.position.z() < height;
    if (run == 0) trial.finish(out);
  }
  out.add("crossings in " + std::to_string(runs) + " runs", "1", through, 0);
  out.add("penetration of leaf spheres 10 ms later", "mm", deepest, kPenetrationPass);
  out.add("force after the limit", "N", force, 8 + 1e-9);
  return out;
}

/// F28: a hand holds still while encoders fluctuate by a count, 0.023 mm, on a surface with friction.
Outcome encoderNoise(ScenarioContext& context, Mode mode) {
  Outcome out;
  constexpr double kCount = 0.023;
  ScenarioRun trial(context.bodies.get("ball"), {{&context.bodies.get("slab"), {}}}, mode, rubbing(0.3));
  trial.to({{0, 0, 8}, kUpright});
  const double z = pressed(trial, {0, 0, 8});
  for (int n = 0; n < 1000; ++n) trial.to({{0.001 * n, 0, z}, kUpright});  // it has slid before, so friction is at its limit
  for (int n = 0; n < 200; ++n) trial.to({{0.999, 0, z}, kUpright});
  Random random(28);
  const Vector3d start = trial.last().graphic.position;
  double swing = 0, max_given = 0, given = 0;
  Vector3d last = trial.last().graphic.position;
  const int steps = context.repetitions(20'000, 2000);
  for (int n = 0; n < steps; ++n) {
    const auto count = [&] { return kCount * std::floor(random.uniform(0, 2)); };
    const double x = count(), y = count();
    const runtime::StepResult r = trial.to({{0.999 + x, y, z + count()}, kUpright});
    swing = std::max(swing, (r.graphic.position - start).head<2>().norm());
    given += r.wrench.force.head<2>().dot((r.graphic.position - last).head<2>());  // friction only dissipates energy
    max_given = std::max(max_given, given);
    last = r.graphic.position;
  }
  out.add("motion of the tool under a tremor of one encoder count", "mm", swing, 2 * kCount);
  out.figures.back().informative = mode != Mode::Constrained;
  out.add("energy that friction gives", "mJ", max_given, 1e-6);
  out.figures.back().informative = mode != Mode::Constrained;
  out.add("penetration of leaf spheres", "mm", trial.leafPenetration(), kPenetrationPass);
  trial.finish(out);
  return out;
}

/// Figures of many runs with moving bodies.
struct CarriedFigures {
  double deepest = 0, force = 0;
  int steps = 0, faults = 0, unanswered = 0, through = 0, stuck = 0;
  void look(ScenarioRun& trial, const runtime::StepResult& r) {
    ++steps;
    faults += r.faults != 0;
    unanswered += !isFinite(r.graphic);
    force = std::max(force, r.limited_wrench.force.norm());
    if (r.faults == 0) deepest = std::max(deepest, trial.leafDepth(r.graphic));
  }
  void addTo(Outcome& out, int runs) const {
    out.add("crossings in " + std::to_string(runs) + " runs", "1", through, 0);
    out.add("penetration while no fault bit is set", "mm", deepest, kPenetrationPass);
    out.add("force after the limit", "N", force, 8 + 1e-9);
    out.add("steps without an answer", "1", unanswered, 0);
    out.add("steps with a fault bit", "%", 100.0 * faults / steps, 0);
    out.figures.back().informative = true;
  }
};

/// F35: a molar closes at 50 mm/s on another one, with a ball of 2 mm between their crowns, until they are 0.5 to 2.5
/// mm apart, and opens. The ball slips aside, or is crushed between cusps.
Outcome closingJaw(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &ball = context.bodies.get("small_ball"), &molar = context.bodies.get("molar");
  double top = 0;
  for (const Vector3d& p : BodyLibrary::mesh("molar").positions) top = std::max(top, p.z());
  constexpr double kOpen = 3, kBy = 0.05;  // height of the crowns above the middle; way in a step
  ScenarioRun::Options options;
  options.moving = true;
  ScenarioRun trial(ball,
                    {{&molar, {{0, 0, -top - kOpen}, kUpright}}, {&molar, {{0, 0, top + kOpen}, rotationOf({std::numbers::pi, 0, 0})}}},
                    mode, options);
  Random random(35);
  CarriedFigures found;
  Vector3d moved[2] = {Vector3d::Zero(), Vector3d::Zero()};
  const auto put = [&](std::size_t k, const Vector3d& at) {
    trial.carryObject(k, at - moved[k]);
    moved[k] = at;
  };
  const int runs = context.repetitions(10'000, 20);
  for (int run = 0; run < runs; ++run) {
    context.progress.check();
    const Vector3d lower(random.uniform(-2, 2), random.uniform(-2, 2), 0), upper(random.uniform(-2, 2), random.uniform(-2, 2), 0);
    const Vector3d hand(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-1, 1));
    put(0, lower);
    put(1, upper);
    trial.restart();
    const int steps = static_cast<int>((2 * kOpen - random.uniform(0.5, 2.5)) / kBy);
    const double half = random.uniform(0, 1);  // share of the lower one
    for (int n = 0; n <= 2 * steps; ++n) {
      const double way = kBy * (n < steps ? n : 2 * steps - n);
      put(0, lower + Vector3d(0, 0, half * way));
      put(1, upper - Vector3d(0, 0, (1 - half) * way));
      found.look(trial, trial.to({hand, kUpright}));
    }
    for (int n = 0; n < 50; ++n) found.look(trial, trial.to({hand, kUpright}));
    const double depth = trial.leafDepth(trial.last().graphic);
    found.through += depth > 1;
    found.stuck += depth > kPenetrationPass;
  }
  found.addTo(out, runs);
  out.add("runs in which the tool stays inside", "1", found.stuck, 0);
  trial.finish(out);
  return out;
}

/// F36: a ball of 2 mm rests at the bottom of a hole, 2.4 mm wide and 5 mm deep, pressed by 1 N. The body with the hole
/// swings by 4 mm in some direction, at up to 100 mm/s, while the hand stays in its place.
Outcome movedPocket(ScenarioContext& context, Mode mode) {
  Outcome out;
  constexpr double kSwing = 4, kSpeed = 100, kWall = 0.2;  // width between ball and wall
  ScenarioRun::Options options;
  options.moving = true;
  ScenarioRun trial(context.bodies.get("small_ball"), {{&context.bodies.get("blind_hole"), {}}}, mode, options);
  Random random(36);
  CarriedFigures found;
  const int runs = context.repetitions(10'000, 20), steps = static_cast<int>(2 * std::numbers::pi * kSwing / kSpeed * 1000);
  const Vector3d hand(0, 0, -5);
  for (int run = 0; run < runs; ++run) {
    context.progress.check();
    const double heading = random.uniform(-std::numbers::pi, std::numbers::pi), rise = random.uniform(-0.2, 0.2);
    const Vector3d swing = kSwing * Vector3d(std::cos(heading), std::sin(heading), rise);
    trial.restart();
    trial.to({{0, 0, -3}, kUpright});
    trial.moveTo(hand, 100);
    Vector3d at = Vector3d::Zero();
    for (int n = 1; n <= steps; ++n) {
      const Vector3d next = n < steps ? Vector3d(std::sin(2 * std::numbers::pi * n / steps) * swing) : Vector3d::Zero();
      trial.carryObject(0, next - at);
      at = next;
      const runtime::StepResult r = trial.to({hand, kUpright});
      found.look(trial, r);
      found.through += (r.graphic.position - at).head<2>().norm() > 2 * kWall;
    }
  }
  found.addTo(out, runs);
  trial.finish(out);
  return out;
}

}  // namespace

std::vector<Scenario> rubbingScenarios() {
  return {{"F23", "stick_slip", "A drag that starts, stops and turns", stickSlip},
          {"F24", "creep", "Held by friction on a slope", creep},
          {"F25", "crush", "Crushed between two bodies", crush},
          {"F26", "chatter", "Between two bodies that shake", chatter},
          {"F27", "body_jump", "A body that comes 20 mm in a step", jumpingBody},
          {"F28", "rub_noise", "Friction with encoder noise", encoderNoise},
          {"F35", "jaw", "A jaw that closes on the tool", closingJaw},
          {"F36", "pocket", "A tool in a pocket that moves", movedPocket}};
}

}  // namespace spheretree::player
