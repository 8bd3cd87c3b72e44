// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios in closed loop: hands on the simulated device, with its mass, friction, encoders and delay. Distances in
// mm, speeds in mm/s. Coulomb friction (0.2 N) contributes much to holding the handle still; where it does, the
// scenario is repeated without it.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "mouth_files.h"
#include "scenarios/closed_loop.h"
#include "spheretree/runtime/step.h"

namespace spheretree::player {
namespace {

constexpr double kTouch = 5;  // height of the ball's centre when it touches a plane at z = 0
constexpr double kNever = 1e9;
const std::array kHands{"arm", "fine", "light", "firm", "teleoperator"};

/// Intended depth of a hand below the touch, with which its spring presses with `force` at 1 N/mm; at most 40 beyond
/// that.
double depthFor(const char* hand, double force) { return force + std::min(40.0, 1000 * force / device::findHand(hand)->stiffness); }

/// The ball moves straight down at `speed` until the hand presses with `force`; from `up_at` on up again, at the same
/// speed.
device::IntendedPath pressPath(const char* hand, double force, double speed, double up_at = kNever) {
  const double way = 4 + depthFor(hand, force);
  return [=](double t) {
    const double down = std::min(speed * t, way), up = std::clamp(speed * (t - up_at), 0.0, way);
    return Configuration{{0, 0, kTouch + 4 - down + up}, kUpright};
  };
}

struct BallOnSlab {
  const Body &ball, &slab;
  double step_time;
  explicit BallOnSlab(ScenarioContext& context, double rate = 1000)
      : ball(context.bodies.get("ball")), slab(context.bodies.get("slab")), step_time(1 / rate) {}
  ScenarioRun trial(Mode mode, const runtime::Coupling& coupling = {}) const {
    ScenarioRun::Options options;
    options.coupling = coupling;
    options.step_time = step_time;
    return ScenarioRun(ball, {{&slab, {}}}, mode, options);
  }
};

void addRoughness(Outcome& out, const std::string& when, const Spectrum& force, double pass) {
  out.add("rms of the force from 30 to 500 Hz, " + when, "mN", 1000 * force.rms, pass);
}

/// Adds the largest force steps in excess of the hand's motion.
void addLargestSteps(Outcome& out, const ScenarioRun& trial) {
  out.add("force step over max(0.1 N, 7 %)", "1", largestForceJump(trial.since(0), {}), 1);
  out.add("torque step over max(5 N mm, 13 %)", "1", largestTorqueJump(trial.since(0), {}), 1);
}

// F16: a hand holds still on a plane and presses with 2 N, through encoders with a resolution of 0.02 mm.
Outcome encoders(ScenarioContext& context, Mode mode) {
  Outcome out;
  const BallOnSlab scene(context);
  const int steps = context.repetitions(10'000, 3000), first_measured = 4000;
  std::array<double, 2> swing{}, rms{};  // with friction, without
  for (const Friction friction : {Friction::On, Friction::Off})
    for (const char* hand : {"fine", "arm"}) {
      ScenarioRun trial = scene.trial(mode);
      const ClosedLoop loop = runHand(context, trial, handAt(hand, 0, friction, pressPath(hand, 2, 10)), first_measured + steps);
      const auto k = static_cast<std::size_t>(friction);
      swing[k] = std::max(swing[k], 1000 * peakToPeak(loop.force(2, first_measured)));
      rms[k] = std::max(rms[k], 1000 * roughness(loop.force(2, first_measured)).rms);
      if (friction == Friction::Off && hand == std::string("fine")) trial.finish(out);
    }
  out.add("force swing while held still", "mN", swing[0], 40);
  out.add("rms of the force from 30 to 500 Hz", "mN", rms[0], 10);
  out.add("force swing without Coulomb friction", "mN", swing[1], 40);
  out.add("rms from 30 to 500 Hz without Coulomb friction", "mN", rms[1], 10);
  out.note = "One count of the encoder is 20 mN. Measured from 4 s on, when the hand has settled. Hands fine and arm.";
  return out;
}

// S1: press, hold, release on a plane, by every hand and with every delay: energy, oscillation, roughness.
Outcome pressHoldRelease(ScenarioContext& context, Mode mode) {
  Outcome out;
  const double rate = context.settings.rate;
  const BallOnSlab scene(context, rate);
  std::array<double, 2> beyond{-kNever, -kNever}, share{};  // with friction, without
  double swing = 0, rms = 0, swing_loose = 0, swing_controlled = 0;
  for (const Friction friction : {Friction::On, Friction::Off})
    for (const char* hand : kHands)
      for (const int delay : {0, 1, 2}) {
        ScenarioRun trial = scene.trial(mode);
        const ClosedLoop loop =
            runHand(context, trial, handAt(hand, delay, friction, pressPath(hand, 2, 100, 3)), 4500, Passivity::Free, rate);
        const auto k = static_cast<std::size_t>(friction);
        beyond[k] = std::max(beyond[k], loop.energyBeyond(1.15));
        if (loop.leak > 0.05) share[k] = std::max(share[k], -loop.lowest_energy / loop.leak);
        if (hand == std::string("teleoperator")) continue;  // 2 kg on 10 N/m: still swings when the others hold still
        const std::vector<double> z = loop.force(2, 2000, 3000);
        if (friction == Friction::On) swing = std::max(swing, 1000 * peakToPeak(z));
        if (friction == Friction::Off && delay == 0) swing_loose = std::max(swing_loose, 1000 * peakToPeak(z));
        if (friction == Friction::On) rms = std::max(rms, 1000 * roughness(z).rms);
        if (friction == Friction::Off && hand == std::string("fine") && delay == 1) trial.finish(out);
        if (friction == Friction::On) continue;
        ScenarioRun again = scene.trial(mode);
        const ClosedLoop controlled =
            runHand(context, again, handAt(hand, delay, friction, pressPath(hand, 2, 100, 3)), 4500, Passivity::Controlled, rate);
        swing_controlled = std::max(swing_controlled, 1000 * peakToPeak(controlled.force(2, 2000, 3000)));
      }
  for (const std::size_t k : {0u, 1u}) {
    const std::string without = k ? ", no Coulomb friction" : "";
    out.add("energy given beyond 1.15 of the sampling's own leak" + without, "mJ", beyond[k], 0.02);
    out.add("energy given over the sampling's own leak" + without, "1", share[k], kNever);
    out.figures.back().informative = true;
  }
  out.add("force swing while pressed", "mN", swing, 40);
  out.add("rms of the force from 30 to 500 Hz while pressed", "mN", rms, 20);
  out.add("force swing while pressed, no Coulomb friction, not late", "mN", swing_loose, 40);
  out.add("force swing while pressed, no Coulomb friction, any delay, passivity control", "mN", swing_controlled, 100);
  out.note =
      "Five hands, delays 0, 1 and 2 steps, with and without Coulomb friction; swings without the teleoperator, which still moves. Without "
      "friction a light hand on a wall that is 2 ms late is unstable by theory: 2.1 N s/m of 2.5.";
  return out;
}

// S2: a slide over the plane at 50 mm/s and about 2 N.
Outcome slide(ScenarioContext& context, Mode mode) {
  Outcome out;
  const BallOnSlab scene(context);
  double rms = 0, torque = 0, line = 0, beyond = -kNever, loose = 0;
  for (const Friction friction : {Friction::On, Friction::Off})
    for (const char* hand : {"fine", "arm"})
      for (const int delay : {0, 1}) {
        ScenarioRun trial = scene.trial(mode);
        const device::IntendedPath press = pressPath(hand, 2, 20);
        const auto path = [=](double t) {
          Configuration at = press(t);
          at.position.x() = -30 + 50 * std::clamp(t - 2, 0.0, 1.2);
          return at;
        };
        const ClosedLoop loop = runHand(context, trial, handAt(hand, delay, friction, path), 3200);
        const Spectrum force = forceRoughness(loop, 2100);
        beyond = std::max(beyond, loop.energyBeyond(1.5));
        if (friction == Friction::Off) {
          loose = std::max(loose, force.rms);
          continue;
        }
        rms = std::max(rms, force.rms);
        line = std::max(line, force.largest_line);
        torque = std::max(torque, torqueRoughness(loop, 2100).rms);
        if (hand == std::string("fine") && delay == 0) trial.finish(out);
      }
  addRoughness(out, "sliding", {rms}, 20);
  out.add("its largest line", "mN", 1000 * line, 10);
  out.add("rms of the torque from 30 to 500 Hz, sliding", "N mm", torque, 1);
  out.add("energy given beyond 1.5 of the sampling's own leak", "mJ", beyond, 0.05);
  addRoughness(out, "no Coulomb friction", {loose}, 20);
  out.figures.back().informative = true;
  return out;
}

// S3: both stiffnesses doubled, with one step of delay: a hard tap must not ring, and a hand that varies its pressure
// must feel no buzz.
Outcome margin(ScenarioContext& context, Mode mode) {
  Outcome out;
  const double rate = context.settings.rate;
  const BallOnSlab scene(context, rate);
  const runtime::Coupling twice{2, 2000};
  std::array<double, 3> ring{}, buzz{};  // with friction, without, and with passivity control
  double beyond = -kNever;
  for (const std::size_t k : {0u, 1u, 2u})
    for (const char* hand : kHands) {
      const Friction friction = k == 0 ? Friction::On : Friction::Off;
      const Passivity passivity = k == 2 ? Passivity::Controlled : Passivity::Free;
      ScenarioRun trial = scene.trial(mode, twice);
      const bool slow = hand == std::string("teleoperator");  // swings at its own 0.4 Hz
      const ClosedLoop tap =
          runHand(context, trial, handAt(hand, 1, friction, pressPath(hand, 8, 300)), slow ? 9000 : 2500, passivity, rate);
      // Frequencies above 30 Hz; the motion of the hand itself is slower.
      ring[k] = std::max(ring[k], 2 * std::sqrt(2.0) * roughness(tap.force(2, slow ? 7500 : 1000)).rms);
      ScenarioRun other = scene.trial(mode, twice);
      const device::IntendedPath press = pressPath(hand, 3, 50);
      const double sway = 2000 / device::findHand(hand)->stiffness;  // an amplitude of 2 N about a mean of 3 N
      const auto path = [=](double t) {
        Configuration at = press(t);
        at.position.z() += std::min(sway, 20.0) * std::sin(2 * std::numbers::pi * t);
        return at;
      };
      const ClosedLoop moving = runHand(context, other, handAt(hand, 1, friction, path), 5000, passivity, rate);
      buzz[k] = std::max(buzz[k], roughness(moving.force(2, 2500)).rms);
      beyond = std::max({beyond, tap.energyBeyond(1.15), moving.energyBeyond(1.15)});
      if (k == 1 && hand == std::string("fine")) other.finish(out);
    }
  out.add("ring after a tap at 300 mm/s, peak to peak", "N", ring[0], 0.1);
  out.add("rms from 30 to 500 Hz while it presses and eases", "mN", 1000 * buzz[0], 20);
  out.add("energy given beyond 1.15 of the sampling's own leak", "mJ", beyond, 0.02);
  out.add("ring without Coulomb friction", "N", ring[1], 0.1);
  out.figures.back().informative = true;
  out.add("rms while it presses and eases, no Coulomb friction", "mN", 1000 * buzz[1], 20);
  out.figures.back().informative = true;
  out.add("ring without Coulomb friction, passivity control", "N", ring[2], 0.1);
  out.add("rms while it presses and eases, no Coulomb friction, passivity control", "mN", 1000 * buzz[2], 20);
  out.figures.back().informative = true;  // a count of the encoder more or less, depending on the damping that the controller may use
  out.note =
      "2 N/mm and 2 N m/rad, one step late, five hands. Without Coulomb friction theory has no quiet wall stiffer than 0.7 N/mm: reported.";
  return out;
}

// S4: the hand releases the handle while it presses; at 2 N also with a damper in parallel with the spring, which mode
// paper does not have.
Outcome letGo(ScenarioContext& context, Mode mode) {
  Outcome out;
  const BallOnSlab scene(context);
  double late = 0, beyond = -kNever;
  const auto speedAt = [&](double force, double damping) {
    ScenarioRun trial = scene.trial(mode, {1, 1000, damping, 0});
    device::SimulatedSettings settings = handAt("fine", 1, Friction::On, pressPath("fine", force, 20));
    settings.release_at = 2;
    const ClosedLoop loop = runHand(context, trial, settings, 6000);
    double speed = 0;
    for (std::size_t n = 2001; n < loop.poses.size(); ++n) {
      const double v = 1000 * (loop.poses[n].position - loop.poses[n - 1].position).norm();
      speed = std::max(speed, v);
      if (n > 4500) late = std::max(late, v);
    }
    beyond = std::max(beyond, loop.energyBeyond(1.15));
    if (force == 2) trial.finish(out);
    return speed;
  };
  out.add("speed of the handle let go at 1 N", "mm/s", speedAt(1, 0), 100);
  out.add("speed of the handle let go at 2 N", "mm/s", speedAt(2, 0), 100);
  out.figures.back().informative = true;  // impossible for an undamped spring of 1 N/mm
  out.add("speed of the handle let go at 2 N, damper of 0.01 N s/mm", "mm/s", speedAt(2, 0.01), 100);
  out.add("speed 2.5 s later: no growing bounce", "mm/s", late, 20);
  out.add("energy given beyond 1.15 of the sampling's own leak", "mJ", beyond, 0.02);
  out.note = "Physics: a spring of 1 N/mm throws 0.159 kg off at F / sqrt(k m), 79 mm/s for each newton, less what friction takes.";
  return out;
}

/// A signal with many lines from 0.1 to 8 Hz, different for each axis; its largest value is about 1.
class Multisine {
 public:
  explicit Multisine(std::uint64_t seed) {
    Random random(seed);
    for (auto& axis : lines_)
      for (std::size_t k = 0; k < axis.size(); ++k) {
        const double hertz = 0.1 * std::pow(80.0, (static_cast<double>(k) + random.uniform(0, 1)) / static_cast<double>(axis.size()));
        axis[k] = {2 * std::numbers::pi * hertz, 2 * std::numbers::pi * random.uniform(0, 1), 0.5 / (1 + hertz)};
      }
  }
  Eigen::Vector3d operator()(double t) const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (int a = 0; a < 3; ++a)
      for (const Line& line : lines_[static_cast<std::size_t>(a)]) sum[a] += line.amplitude * std::sin(line.rate * t + line.phase);
    return sum;
  }

 private:
  struct Line {
    double rate, phase, amplitude;
  };
  std::array<std::array<Line, 12>, 3> lines_;
};

// S5: a peg of 10 mm in a hole of 10.2 mm, and a fine probe in a sulcus, both swayed.
Outcome tight(ScenarioContext& context, Mode mode) {
  Outcome out;
  double deepest = 0, beyond = -kNever, left = 0;
  Spectrum force, torque;
  // `depth`: depth that must be reached; the hand aims `further`, since friction holds it back by up to 1.5.
  const auto insert = [&](const char* tool, const char* object, double depth, double further, bool is_shown) {
    for (const char* hand : {"fine", "arm"})
      for (const int delay : {0, 1}) {
        ScenarioRun trial(context.bodies.get(tool), {{&context.bodies.get(object), {}}}, mode);  // the tip is the reference point
        const auto path = [=](double t) {
          const double way = 2 + depth + further, in = std::clamp(t - 2, 0.0, 1.0);
          const double z = 2 - std::min(10 * t, way) + std::clamp(10 * (t - 5), 0.0, way);
          return Configuration{{in * std::sin(3 * t), in * std::cos(5 * t), z},
                               rotationOf({0.05 * in * std::sin(4 * t), 0.05 * in * std::sin(2.3 * t), 0})};
        };
        const ClosedLoop loop = runHand(context, trial, handAt(hand, delay, Friction::On, path), 7000);
        double lowest = 0;
        for (const Configuration& pose : loop.poses) lowest = std::min(lowest, pose.position.z());
        left = std::max(left, depth + lowest);
        deepest = std::max(deepest, trial.leafPenetration());
        beyond = std::max(beyond, loop.energyBeyond(1.5));
        const Spectrum f = forceRoughness(loop, 2000, 5000), m = torqueRoughness(loop, 2000, 5000);
        force = {std::max(force.rms, f.rms), std::max(force.largest_line, f.largest_line)};
        torque = {std::max(torque.rms, m.rms), std::max(torque.largest_line, m.largest_line)};
        if (is_shown && hand == std::string("fine") && delay == 1) trial.finish(out);
      }
  };
  const auto report = [&](const std::string& where) {
    addRoughness(out, where, force, 50);
    out.add("rms of the torque from 30 to 500 Hz, " + where, "N mm", torque.rms, 2);
    out.add("depth that was not reached, " + where, "mm", std::max(0.0, left), 0.5);
    force = torque = {};
    left = 0;
  };
  insert("peg", "bore", 3.5, 1.4, true);
  report("peg");
  insert("fine_probe", "sulcus", 3, 1.5, false);
  report("sulcus");
  out.add("penetration of leaf spheres", "mm", deepest, kPenetrationPass);
  out.add("energy given beyond 1.5 of the sampling's own leak", "mJ", beyond, 0.05);
  out.note = "Hands fine and arm, 0 and 1 ms late. Play of the peg in the hole: 0.1 mm less overhangs of at most " +
             text(leafOverhang(context.bodies.get("peg"))) + " mm (peg) and 0.05 mm (inside of the hole).";
  return out;
}

// S6: the probe moves over both arches of the sample mouth, 28 teeth, as a dentist feels along them.
Outcome arch(ScenarioContext& context, Mode mode) {
  Outcome out;
  static const std::vector<Configuration> whole = samples::inspectTeeth(samples::makeMouth());
  std::vector<PlacedBody> teeth;
  for (const int quadrant : {1, 2, 3, 4})
    for (int n = 1; n <= 7; ++n) teeth.push_back({&context.bodies.get("tooth_" + std::to_string(10 * quadrant + n)), {}});
  ScenarioRun trial(context.bodies.get("dental_probe"), teeth, mode);
  const auto path = [&](double t) { return whole[std::min(whole.size() - 1, static_cast<std::size_t>(std::lround(1000 * t)))]; };
  const int steps = context.repetitions(static_cast<int>(whole.size()), 6000);
  const ClosedLoop loop = runHand(context, trial, handAt("fine", 1, Friction::On, path), steps);
  out.add("penetration of leaf spheres", "mm", trial.leafPenetration(), kPenetrationPass);
  addLargestSteps(out, trial);
  out.add("energy given beyond 1.5 of the sampling's own leak", "mJ", loop.energyBeyond(1.5), 0.05);
  addRoughness(out, "on the teeth", forceRoughness(loop, 0), 50);
  out.add("processor time of a step, p99.9", "us", trial.times().quantile(0.999), 500);
  out.add("processor time of a step, max", "us", trial.times().largest(), 1000);
  out.note = "28 teeth; hand fine, 1 ms late, means to be 0.4 mm inside. A part of the path at a small share.";
  trial.finish(out);
  return out;
}

// S7: a hand moves randomly over a molar, with 0.1 to 8 Hz, for a minute.
Outcome multisine(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun trial(context.bodies.get("dental_probe"), {{&context.bodies.get("molar"), {}}}, mode);
  const Multisine way(7), turn(8);
  const auto path = [&](double t) {
    const double down = std::min(5 * t, 12.0);  // from above into the middle of the motion's range
    return Configuration{Eigen::Vector3d(0, 0, 16 - down) + 6 * way(t), rotationOf(0.3 * turn(t))};
  };
  double loudest = 0;
  const ClosedLoop loop = runHand(context, trial, handAt("arm", 1, Friction::On, path), context.repetitions(60'000, 6000));
  for (std::size_t begin = 2000; begin + 1000 <= loop.sent.size(); begin += 1000)
    loudest = std::max(loudest, forceRoughness(loop, begin, begin + 1000).rms);
  int touching = 0;
  for (const RecordedStep& row : trial.rows()) touching += row.active > 0;
  out.add("penetration of leaf spheres", "mm", trial.leafPenetration(), kPenetrationPass);
  out.add("energy given beyond 1.5 of the sampling's own leak", "mJ", loop.energyBeyond(1.5), 0.05);
  addLargestSteps(out, trial);
  out.add("rms from 30 to 500 Hz of the loudest second", "mN", 1000 * loudest, 50);
  out.figures.back().informative = true;  // includes taps and falls off edges
  out.add("share of the time in contact", "%", 100.0 * touching / static_cast<double>(trial.rows().size()), 100);
  out.figures.back().informative = true;
  trial.finish(out);
  return out;
}

}  // namespace

std::vector<Scenario> handScenarios() {
  return {{"F16", "encoders", "Quantised encoders, held still (closed loop)", encoders},
          {"S1", "press", "Press, hold, release (closed loop)", pressHoldRelease, true, true, true},
          {"S2", "slide", "Slide at 50 mm/s (closed loop)", slide},
          {"S3", "margin", "Twice the stiffness (closed loop)", margin, true, true, true},
          {"S4", "let-go", "The hand lets go (closed loop)", letGo},
          {"S5", "tight", "Peg in a hole, probe in a sulcus (closed loop)", tight},
          {"S6", "arch", "Probe along a dental arch (closed loop)", arch},
          {"S7", "multisine", "A minute at random, 0.1 to 8 Hz (closed loop)", multisine}};
}

}  // namespace spheretree::player
