// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of soft tissue, with large deformation (solver in lock step) and, where noted, small deformation. Distances
// in mm, speeds in mm/s. In the mode of the paper tissue is rigid.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenarios/scenario_run.h"
#include "step/coupling_wrench.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;

constexpr double kTipRadius = 3;      // of the tip
constexpr double kMaxForce = 8;       // WrenchLimits [N]
constexpr double kEnergyPass = 0.05;  // [mJ]

ScenarioRun::Options tissueOptions(bool is_large) {
  ScenarioRun::Options options;
  options.large_motion = is_large;
  return options;
}

/// Moves down at `speed` until the tool is `depth` below the surface z = 0; returns the position of the hand then.
/// Gives up at 12 mm more.
Vector3d press(ScenarioRun& trial, const Vector3d& over, double depth, double speed = 10) {
  Vector3d hand = over;
  for (const double end = over.z() - 2 - depth - 12; hand.z() > end && trial.last().graphic.position.z() > kTipRadius - depth;)
    trial.to({hand -= Vector3d(0, 0, speed / 1000), kUpright});
  return hand;
}

void hold(ScenarioRun& trial, const Vector3d& hand, int steps) {
  for (int n = 0; n < steps; ++n) trial.to({hand, kUpright});
}

/// Energy that the hand received along a closed path that starts and ends out of contact, in excess of the energy that
/// holding a spring's force for a step generates [mJ].
double energyGiven(const ScenarioRun& trial) {
  double given = 0;
  const std::vector<RecordedStep>& rows = trial.rows();
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Vector3d way = rows[i].haptic.position - rows[i - 1].haptic.position, force = rows[i - 1].wrench.force;
    if (force.norm() == 0) continue;
    given += force.dot(way) - 0.5 * trial.coupling().translation * way.squaredNorm();
  }
  return given;
}

double maxForce(const ScenarioRun& trial) {
  double largest = 0;
  for (const RecordedStep& row : trial.rows()) largest = std::max(largest, runtime::limited(row.wrench, {}).force.norm());
  return largest;
}

/// How tissue that the tool touches from `side` of z, 1 or -1, pulls it in the opposite direction.
struct Pull {
  double force = 0;  // largest force [N]
  int steps = 0;     // largest number of consecutive steps above 0.05 N
  /// A tool that is caught for a shorter time comes free by itself.
  bool isThrough() const { return steps > 10; }
};

Pull pullOf(const ScenarioRun& trial, double side) {
  Pull pull;
  int steps = 0;
  for (const RecordedStep& row : trial.rows()) {
    const double force = -side * row.wrench.force.z();
    pull.force = std::max(pull.force, force);
    steps = force > 0.05 ? steps + 1 : 0;
    pull.steps = std::max(pull.steps, steps);
  }
  return pull;
}

/// The rules that every path must keep.
void addRules(Outcome& out, const ScenarioRun& trial, const std::string& which) {
  out.add("force step over max(0.1 N, 7 %)" + which, "1", largestForceJump(trial.rows(), trial.coupling()), 1);
  out.add("energy given beyond the sampling's own leak" + which, "mJ", energyGiven(trial), kEnergyPass);
  out.add("force after the limit" + which, "N", maxForce(trial), kMaxForce + 1e-9);
}

/// F29: the tip is pressed 2 mm into a block, held for two seconds, and moves out. Repeated ten times as slowly: energy
/// that tissue generates because its states are delayed then decreases.
Outcome poke(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Vector3d start(1, -0.7, kTipRadius + 1);
  const auto rigOf = [&](bool is_large) {
    return ScenarioRun(context.bodies.get("tip"), {{&context.bodies.getSoft("soft_block"), {}}}, mode, tissueOptions(is_large));
  };
  for (const bool is_large : {true, false}) {
    ScenarioRun trial = rigOf(is_large);
    trial.to({start, kUpright});
    const Vector3d hand = press(trial, start, 2);
    hold(trial, hand, 1000);
    double low = 1e9, high = 0;
    for (int n = 0; n < 1000; ++n) {
      const double force = trial.to({hand, kUpright}).wrench.force.norm();
      low = std::min(low, force), high = std::max(high, force);
    }
    trial.moveTo(start, 10);
    hold(trial, start, 10);
    const std::string which = is_large ? "" : ", small motion";
    out.add("trembling while it holds, peak to peak" + which, "mN", 1000 * (high - low), 5);
    addRules(out, trial, which);
    if (is_large) trial.finish(out);
  }
  ScenarioRun trial = rigOf(true);
  trial.to({start, kUpright});
  press(trial, start, 2, 1);
  trial.moveTo(start, 1);
  out.add("energy given beyond the sampling's own leak, at 1 mm/s", "mJ", energyGiven(trial), kEnergyPass);
  out.figures.back().informative = true;
  return out;
}

/// F30: a cheek of 2 mm, 1 mm above a rigid jaw: the tip presses the cheek on the jaw, until the hand is 4 mm below the
/// jaw's surface, and returns.
Outcome squeeze(ScenarioContext& context, Mode mode) {
  Outcome out;
  for (const bool is_large : {true, false}) {
    const std::vector<PlacedBody> objects{{&context.bodies.getSoft("cheek"), {}}, {&context.bodies.get("slab"), {{0, 0, -2}, kUpright}}};
    ScenarioRun trial(context.bodies.get("tip"), objects, mode, tissueOptions(is_large));
    const Vector3d start(0.6, 0.4, kTipRadius + 2), low(0.6, 0.4, kTipRadius - 6);
    trial.to({start, kUpright});
    trial.moveTo(low, 20);
    hold(trial, low, 500);
    trial.moveTo(start, 20);
    hold(trial, start, 200);
    const std::string which = is_large ? "" : ", small motion";
    out.add("penetration of the jaw" + which, "mm", trial.leafPenetration(), kPenetrationPass);
    out.add("crossings of the cheek" + which, "1", pullOf(trial, 1).isThrough(), 0);
    addRules(out, trial, which);
    const auto has_fault = [](const RecordedStep& row) { return row.faults != 0; };
    out.add("steps with a fault bit" + which, "1", double(std::count_if(trial.rows().begin(), trial.rows().end(), has_fault)), 0);
    out.figures.back().informative = true;
    if (is_large) trial.finish(out);
  }
  return out;
}

/// F31: a drag over a soft block, 1 mm deep, onto a rigid one beside it that is 0.5 mm higher, and back.
Outcome slipOff(ScenarioContext& context, Mode mode) {
  Outcome out;
  for (const bool is_large : {true, false}) {
    const std::vector<PlacedBody> objects{{&context.bodies.getSoft("soft_block"), {{-12, 0, 0}, kUpright}},
                                          {&context.bodies.get("block"), {{30, 0, 0.5}, kUpright}}};
    ScenarioRun trial(context.bodies.get("tip"), objects, mode, tissueOptions(is_large));
    const Vector3d start(-9, 0.5, kTipRadius + 1);
    trial.to({start, kUpright});
    const Vector3d hand = press(trial, start, 1);
    hold(trial, hand, 200);
    trial.moveTo(hand + Vector3d(18, 0, 0), 20);
    hold(trial, hand + Vector3d(18, 0, 0), 200);
    trial.moveTo(hand, 20);
    hold(trial, hand, 200);
    trial.moveTo(start, 20);
    hold(trial, start, 50);
    const std::string which = is_large ? "" : ", small motion";
    out.add("penetration of the rigid block" + which, "mm", trial.leafPenetration(), kPenetrationPass);
    addRules(out, trial, which);
    if (is_large) trial.finish(out);
  }
  return out;
}

/// F32: against a cheek of 2 mm at 1 m/s from either side, until the hand is 9 mm beyond its middle, and back at half
/// of that speed. The tool has passed through if it is then held back for more than 10 ms.
Outcome fastCheek(ScenarioContext& context, Mode mode) {
  Outcome out;
  const int runs = context.repetitions(10'000, 4);  // in each motion
  Random random(32);
  int through[2] = {0, 0};
  double caught[2] = {0, 0};
  double force = 0, late = 0;
  for (int run = 0; run < 2 * runs; ++run) {
    context.progress.check();
    const double side = run % 2 == 0 ? 1 : -1;
    const bool is_large = run / 2 % 2 == 0;
    const ScenarioRun::Options options = tissueOptions(is_large);
    ScenarioRun trial(context.bodies.get("tip"), {{&context.bodies.getSoft("cheek"), {}}}, mode, options);
    const Vector3d across(random.uniform(-8, 8), random.uniform(-8, 8), 0),
        start = across + Vector3d(0, 0, side * (kTipRadius + 1.1 + random.uniform(0, 1)));
    trial.to({start, kUpright});
    const Vector3d past = across - Vector3d(0, 0, side * 9);
    trial.moveTo(past, 1000);
    hold(trial, past, 20);
    trial.moveTo(start, 500);
    hold(trial, start, 50);
    force = std::max(force, maxForce(trial));
    late = std::max(late, trial.last().wrench.force.norm());
    const Pull pulled = pullOf(trial, side);
    through[is_large] += pulled.isThrough();
    caught[is_large] = std::max(caught[is_large], pulled.force);
    if (run == 0) trial.finish(out);
  }
  out.add("crossings in " + std::to_string(runs) + " runs", "1", through[true], 0);
  out.add("crossings in " + std::to_string(runs) + " runs, small motion", "1", through[false], 0);
  out.add("force that holds the tool back as it comes out", "N", caught[true], 0.1);
  out.add("force that holds the tool back as it comes out, small motion", "N", caught[false], 0.1);
  out.add("force after the limit", "N", force, kMaxForce + 1e-9);
  out.add("force that pushes the tool off, 50 ms after it is back", "N", late, 0);
  out.figures.back().informative = true;
  return out;
}

/// A hand that moves back and forth by 0.3 mm, twice in 500 steps, around the point where it pressed.
template <class Look>
void sway(ScenarioRun& trial, const Vector3d& hand, const Look& look) {
  for (int n = 1; n <= 500; ++n) {
    trial.to({hand + Vector3d(0, 0, 0.3 * std::sin(0.008 * std::numbers::pi * n)), kUpright});
    look();
  }
}

/// The tip is pressed in, drawn along, and lifted, while states come at other times than the steps expect.
void drawWithLateStates(ScenarioContext& context, Mode mode, std::uint64_t least, std::uint64_t most, const std::string& which,
                        Outcome& out) {
  ScenarioRun trial(context.bodies.get("tip"), {{&context.bodies.getSoft("soft_block"), {}}}, mode);
  const Vector3d start(1, -0.7, kTipRadius + 1);
  trial.setStatePeriod(least, most);
  trial.to({start, kUpright});
  const Vector3d hand = press(trial, start, 2);
  trial.moveTo(hand + Vector3d(4, 0, 0), 20);
  trial.moveTo(start + Vector3d(4, 0, 0), 20);
  hold(trial, start + Vector3d(4, 0, 0), 300);
  double deepest = 0;
  for (const RecordedStep& row : trial.rows()) deepest = std::max(deepest, row.penetration);
  out.add("penetration of the surface, " + which, "mm", deepest, 0.01);
  out.add("force after the tool is out, " + which, "N", trial.last().wrench.force.norm(), 1e-6);
}

/// F33: the solver gives no state for half a second, while the tip is in the tissue and the hand moves; it is slow; and
/// it is irregular.
Outcome stalls(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun trial(context.bodies.get("tip"), {{&context.bodies.getSoft("soft_block"), {}}}, mode);
  const Vector3d start(1, -0.7, kTipRadius + 1);
  trial.to({start, kUpright});
  const Vector3d hand = press(trial, start, 2);
  hold(trial, hand, 500);
  const Vector3d before = trial.last().wrench.force;
  trial.setSolver(ScenarioRun::Solver::Stalls);
  double away = 0;
  sway(trial, hand, [&] { away = std::max(away, kTipRadius - trial.last().graphic.position.z()); });
  trial.setSolver(ScenarioRun::Solver::Runs);
  hold(trial, hand, 500);
  const double off = (trial.last().wrench.force - before).norm() / before.norm();
  trial.moveTo(start, 10);
  hold(trial, start, 10);
  out.add("change of the force by a stall, once the solver goes on [%]", "1", 100 * off, 5);
  out.add("depth of the tool meanwhile", "mm", away, 3);
  addRules(out, trial, "");
  trial.finish(out);
  drawWithLateStates(context, mode, 33, 33, "states every 33 ms", out);
  drawWithLateStates(context, mode, 1, 300, "states every 1 to 300 ms", out);
  return out;
}

/// F34: the solver fails for half a second, while the hand moves, and until the tool is out. If the tissue has become
/// stiffer, a state that was found under a force protrudes when the force is gone: the tool is free above that surface.
Outcome diverges(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun trial(context.bodies.get("tip"), {{&context.bodies.getSoft("soft_block"), {}}}, mode);
  const Vector3d start(1, -0.7, kTipRadius + 1);
  trial.to({start, kUpright});
  const Vector3d hand = press(trial, start, 2);
  hold(trial, hand, 500);
  trial.setSolver(ScenarioRun::Solver::Diverges);
  int unsaid = 0, frozen = 0;
  const auto look = [&] {
    frozen += trial.isFrozen();
    unsaid += trial.isFrozen() && !(trial.last().faults & runtime::kTissueFrozen);
  };
  sway(trial, hand, look);
  double height = 0;
  for (Vector3d out_at = trial.last().haptic.position; out_at.z() < kTipRadius + 5; out_at.z() += 0.01)
    if (trial.to({out_at, kUpright}).wrench.force.norm() > 0) height = out_at.z() - kTipRadius;
  const double held = trial.last().wrench.force.norm();
  trial.setSolver(ScenarioRun::Solver::Runs);
  hold(trial, trial.last().haptic.position, 500);
  trial.moveTo(start, 10);
  const double stuck = (trial.last().faults & runtime::kTissueFrozen) != 0;
  out.add("steps without the fault bit of frozen tissue", "1", mode == Mode::Constrained && frozen == 0 ? 500 : unsaid, 0);
  out.add("force once the tool is out", "N", held, 1e-6);
  out.add("height above the tissue at rest where it is free", "mm", height, 0);
  out.figures.back().informative = true;
  out.add("fault bits after the solver has gone on", "1", stuck, 0);
  addRules(out, trial, "");
  trial.finish(out);
  return out;
}

}  // namespace

std::vector<Scenario> tissueScenarios() {
  return {{"F29", "poke", "Soft tissue poked and held", poke},
          {"F30", "squeeze", "Soft tissue between the tool and a jaw", squeeze},
          {"F31", "slip_off", "Off soft tissue onto a tooth", slipOff},
          {"F32", "cheek", "A cheek of 2 mm at 1 m/s", fastCheek},
          {"F33", "stall", "A solver of soft tissue that stalls, is slow or irregular", stalls},
          {"F34", "diverge", "A solver of soft tissue that diverges", diverges}};
}

}  // namespace spheretree::player
