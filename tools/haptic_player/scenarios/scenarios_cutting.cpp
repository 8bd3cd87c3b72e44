// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of a burr that cuts. Distances in mm, speeds in mm/s. In the mode of the paper nothing is cut. Each run has
// a burr, a turn of the block, a pressure, a feed and thus a rate of removal of its own; and in every second pair of
// runs the burr rubs, too. Rubbing takes its energy from the spindle, and its force is none of Preston's: energy and
// law are those of the other runs.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cavity.h"
#include "scenarios/scenario_run.h"
#include "step/coupling_wrench.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;

constexpr int kRuns = 1430;           // of each of the seven scenarios: 10,000 in all
constexpr double kWallPass = 0.03;    // 0.02 by which a wall may stand behind, and kPenetrationPass [mm]
constexpr double kLawPass = 2;        // [%]
constexpr double kFeedStepPass = 20;  // at constant feed in one layer [mN]
constexpr double kCaughtPass = 0.1;   // F5, of a tool that is caught as it comes out [N]
constexpr double kFineBurr = 0.35;    // radius of the burr of fine_handpiece
constexpr double kRubs = 0.5;         // tangential force, as a share of the force
constexpr double kApproach = 0.2;     // height of the burr above the block at the beginning
constexpr double kOut = 20;           // speed on the way out
constexpr double kAhead = 6;          // the hand goes no farther ahead of the burr
constexpr int kLongestFeed = 10000;   // steps
const Vector3d kUp = Vector3d::UnitZ();

double logUniform(Random& random, double low, double high) { return low * std::pow(high / low, random.uniform(0, 1)); }

Quaternion randomTurn(Random& random) {
  Eigen::Vector4d q;
  do {
    for (double& x : q) x = random.uniform(-1, 1);
  } while (!(q.norm() > 0.1 && q.norm() < 1));
  return Quaternion(q[0], q[1], q[2], q[3]).normalized();
}

/// A tilt by up to `most` degrees about a horizontal axis.
Quaternion randomTilt(Random& random, double most) {
  const double angle = random.uniform(0, most) * std::numbers::pi / 180, heading = random.uniform(0, 2 * std::numbers::pi);
  return rotationOf(angle * Vector3d(std::cos(heading), std::sin(heading), 0));
}

/// What a run has of its own.
struct Drilling {
  double radius;      // of the burr
  double pressure;    // of the hand in a straight plunge, as soon as it is steady [N]
  double feed;        // of the hand
  double rate;        // of removal, from both of them [mm/(N s)]
  double tangential;  // 0: it does not rub
  Quaternion turn;    // of the block
  bool is_spun_out;   // the burr spins when it comes out

  Drilling(Random& random, int run, double least_pressure, double most_pressure)
      : radius(run % 2 == 0 ? samples::kBurr.radius : kFineBurr),
        pressure(logUniform(random, least_pressure, most_pressure)),
        feed(logUniform(random, 2, 50)),
        rate(feed / pressure),
        tangential(run % 4 < 2 ? 0 : kRubs),
        turn(randomTurn(random)),
        is_spun_out(random.uniform(0, 1) < 0.5) {}
  const char* tool() const { return radius == kFineBurr ? "fine_handpiece" : "handpiece"; }
  Vector3d start(Random& random) const { return {random.uniform(-1, 1), random.uniform(-1, 1), radius + kApproach}; }
};

/// All runs of scenario `number`, with their pressures [N]. `run` is called with a Drilling and the random numbers.
template <class Run>
void eachRun(ScenarioContext& context, int number, double least_pressure, double most_pressure, Run&& run) {
  Random random(static_cast<std::uint64_t>(number));
  const int runs = context.repetitions(kRuns, 4);
  for (int n = 0; n < runs; ++n) run(Drilling(random, n, least_pressure, most_pressure), random);
}

/// Drives a handpiece by the position of its burr in the axes of the block.
class Drill {
 public:
  /// `handle`: height of the reference point above the burr.
  Drill(ScenarioContext& context, Mode mode, const char* block, const Drilling& with, double handle = 0,
        std::vector<runtime::CutLayer> inner = {})
      : turn_(with.turn),
        handle_(0, 0, handle),
        rate_(std::numbers::pi * with.radius * with.radius * with.rate),
        trial_(context.bodies.get(with.tool()), {{&context.bodies.get(block), {Vector3d::Zero(), with.turn}}}, mode,
               optionsOf(with, handle, std::move(inner))) {
    context.progress.check();
  }

  void to(const Vector3d& burr) {
    hand_ = burr;
    trial_.to({turn_ * (burr + tilt * handle_), turn_ * tilt});
    if (spins_) impulse_ += trial_.last().wrench.force.norm() / 1000;
  }
  void begin(const Vector3d& burr) {
    to(burr);
    spin(true);
  }
  void moveTo(const Vector3d& burr, double speed) {
    const Vector3d from = hand_, way = burr - from;
    const int steps = std::max(1, static_cast<int>(std::ceil(1000 * way.norm() / speed - 1e-9)));
    for (int n = 1; n <= steps; ++n) to(from + way * (double(n) / steps));
  }
  /// Feeds the hand along `way` until the burr has gone that far. The hand waits while it is `most` ahead of the burr.
  void feed(const Vector3d& way, double speed, double most) {
    const Vector3d along = way.normalized();
    const double end = along.dot(burr()) + way.norm();
    for (int n = 0; n < kLongestFeed && along.dot(burr()) < end; ++n)
      to(along.dot(hand_ - burr()) < most ? Vector3d(hand_ + speed / 1000 * along) : hand_);
  }
  /// The hand stops to press.
  void release() {
    moveTo(burr(), kOut);
    moveTo(burr(), kOut);
    hold(20);
  }
  void hold(int steps) {
    for (int n = 0; n < steps; ++n) to(hand_);
  }
  /// To the start, and a few steps there. Returns the largest force along `back`, against the motion [N].
  double comeOut(const Vector3d& start, const Vector3d& back) {
    const std::size_t mark = trial_.mark();
    moveTo(start, kOut);
    hold(5);
    double caught = 0;
    for (const RecordedStep& row : trial_.since(mark)) caught = std::max(caught, (turn_ * back).dot(row.wrench.force));
    return caught;
  }
  void spin(bool turns) {
    trial_.setSpindle(turns);
    spins_ = turns;
  }

  Quaternion tilt = kUpright;  // of the hand, in the axes of the block
  const Vector3d& hand() const { return hand_; }
  Vector3d burr() const {  // of the graphic tool, in the axes of the block
    const Configuration& graphic = trial_.last().graphic;
    return turn_.conjugate() * (graphic.position - graphic.orientation * handle_);
  }
  double force() const { return trial_.last().wrench.force.norm(); }
  /// Preston's law of the outermost layer, for the forces of all steps in which the burr spun [mm^3].
  double volumeByLaw() const { return rate_ * impulse_; }
  double removed() const {
    double sum = 0;
    for (std::size_t layer = 0; layer < runtime::kMaxCutLayers; ++layer) sum += trial_.removedOf(layer);
    return sum;
  }
  ScenarioRun& trial() { return trial_; }

 private:
  static ScenarioRun::Options optionsOf(const Drilling& with, double handle, std::vector<runtime::CutLayer> inner) {
    ScenarioRun::Options options;
    options.reference_point = handle * kUp;
    options.cutting = Cutting{{{Vector3d::Zero(), with.radius}}, {with.rate, std::move(inner), with.tangential}};
    return options;
  }

  Quaternion turn_;
  Vector3d handle_, hand_{0, 0, 0};
  double rate_, impulse_ = 0;
  bool spins_ = false;
  ScenarioRun trial_;
};

/// Archimedes: the volume of a ball of radius r that came straight down from above a plane to `depth` below it, of all
/// that is less than `depth` below it.
double drilled(double depth, double r) {
  const double cap = std::clamp(depth, 0.0, r);
  return std::numbers::pi * (cap * cap * (r - cap / 3) + r * r * std::max(0.0, depth - r));
}

/// The area of a circle of radius r that is below a line, which its lowest point is `depth` below.
double channelArea(double depth, double r) {
  const double up = std::clamp(1 - depth / r, -1.0, 1.0);
  return r * r * (std::acos(up) - up * std::sqrt(1 - up * up));
}

double percentOff(double volume, double by_law) { return volume > 0 && by_law > 0 ? 100 * std::abs(volume / by_law - 1) : 100; }

/// Largest change of the force in a step beyond the motion of the hand, with a spring of 1 N/mm [mN].
double largestFeedStep(std::span<const RecordedStep> rows) {
  double largest = 0;
  for (std::size_t i = 1; i < rows.size(); ++i)
    largest = std::max(
        largest, (rows[i].wrench.force - rows[i - 1].wrench.force).norm() - (rows[i].haptic.position - rows[i - 1].haptic.position).norm());
  return 1000 * largest;
}

/// The most energy that the hand had received at any step, in excess of 1.5 times what springs whose wrench is held for
/// a step give [mJ].
double energyBeyondLeak(std::span<const RecordedStep> rows, const runtime::Coupling& coupling) {
  double given = 0, most = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Wrench& wrench = rows[i - 1].wrench;
    if (wrench.force.norm() == 0) continue;
    const Displacement way = displacementBetween(rows[i - 1].haptic, rows[i].haptic);
    const double leak = 0.5 * (coupling.translation * way.translation.squaredNorm() + coupling.rotation * way.rotation.squaredNorm());
    given += wrench.force.dot(way.translation) + wrench.torque.dot(way.rotation) - 1.5 * leak;
    most = std::max(most, given);
  }
  return most;
}

/// The figures that all of these scenarios have.
class CutFigures {
 public:
  /// At the end of each run.
  void look(Drill& drill, const Drilling& with, Outcome& out) {
    ScenarioRun& trial = drill.trial();
    passages_ += trial.passages() > 0;
    deepest_ = std::max(deepest_, trial.leafPenetration());
    force_step_ = std::max(force_step_, largestForceJump(trial.rows(), trial.coupling()));
    torque_step_ = std::max(torque_step_, largestTorqueJump(trial.rows(), trial.coupling()));
    if (with.tangential == 0) energy_ = std::max(energy_, energyBeyondLeak(trial.rows(), trial.coupling()));
    for (const RecordedStep& row : trial.rows()) {
      force_ = std::max(force_, runtime::limited(row.wrench, {}).force.norm());
      faults_ += row.faults != 0;
      if (row.spins && row.wrench.force.norm() > 0) times_.add(row.total_us);
    }
    steps_ += trial.rows().size();
    if (++runs_ == 1) trial.finish(out);
  }
  void addTo(Outcome& out) const {
    out.add("passages of parts that do not cut, in " + std::to_string(runs_) + " runs", "1", passages_, 0);
    out.add("penetration of parts that do not cut", "mm", deepest_, kWallPass);
    out.add("force step over max(0.1 N, 7 %)", "1", force_step_, 1);
    out.add("torque step over max(5 N mm, 13 %)", "1", torque_step_, 1);
    out.add("energy given beyond 1.5 of the sampling's own leak", "mJ", energy_, 0.05);
    out.add("force after the limit", "N", force_, runtime::WrenchLimits{}.force + 1e-9);
    out.add("processor time of a step that cuts, p99", "us", times_.quantile(0.99), 150);
    out.add("processor time of a step that cuts, p99.9", "us", times_.quantile(0.999), 500);
    out.add("steps with a fault bit", "%", 100.0 * static_cast<double>(faults_) / static_cast<double>(std::max<std::size_t>(steps_, 1)), 0);
    out.figures.back().informative = true;
  }

 private:
  int runs_ = 0, passages_ = 0;
  std::size_t steps_ = 0, faults_ = 0;
  double deepest_ = 0, force_step_ = 0, torque_step_ = 0, energy_ = 0, force_ = 0;
  TimeHistogram times_;
};

/// F37: the burr is pressed straight into the block at a constant feed, held, and comes out, spinning or not.
Outcome plunge(ScenarioContext& context, Mode mode) {
  Outcome out;
  CutFigures found;
  double law = 0, feed_step = 0, caught = 0, late = 0;
  eachRun(context, 37, 0.3, 3, [&](const Drilling& with, Random& random) {
    Drill drill(context, mode, "small_block", with);
    const Vector3d start = with.start(random);
    drill.begin(start);
    drill.feed(-(kApproach + random.uniform(0.3, 2)) * kUp, with.feed, kAhead);
    feed_step = std::max(feed_step, largestFeedStep(drill.trial().rows()));
    if (with.tangential == 0) law = std::max(law, percentOff(drilled(with.radius - drill.burr().z(), with.radius), drill.volumeByLaw()));
    drill.release();
    drill.spin(with.is_spun_out);
    const double back = drill.comeOut(start, -kUp);
    if (with.tangential == 0) caught = std::max(caught, back);
    late = std::max(late, drill.force());
    found.look(drill, with, out);
  });
  out.add("volume off Preston's law", "%", law, kLawPass);
  out.add("step of the force beyond the hand's own, at constant feed", "mN", feed_step, kFeedStepPass);
  out.add("force that holds the tool back as it comes out", "N", caught, kCaughtPass);
  out.add("force once it is out", "N", late, 1e-6);
  found.addTo(out);
  return out;
}

/// F38: the burr comes from beside the block and cuts a channel along its face, from edge to edge. The law is that of
/// the way between, where the channel is open at both of its sides.
Outcome sideCut(ScenarioContext& context, Mode mode) {
  constexpr double kEdge = 3, kBetween = 2;  // half of the length of the block, and of the part of the channel
  Outcome out;
  CutFigures found;
  double law = 0, feed_step = 0, late = 0;
  eachRun(context, 38, 0.1, 0.6, [&](Drilling with, Random& random) {
    const double r = with.radius, depth = random.uniform(0.2, 0.9) * r, feed = std::max(with.feed, 5.0);
    with.rate = channelArea(depth, r) * feed / (std::numbers::pi * r * r * with.pressure);
    Drill drill(context, mode, "small_block", with);
    const Vector3d start(-kEdge - r - kApproach, random.uniform(-2, 2), r - depth), way = Vector3d(2 * (kEdge + r) + 1, 0, 0);
    drill.begin(start);
    double cut = 0, by_law = 0;
    std::size_t first = 0, end = 0;
    const int steps = static_cast<int>(1000 * way.norm() / feed);
    for (int n = 1; n <= steps; ++n) {
      const Vector3d before = drill.burr();
      const double law_before = drill.volumeByLaw();
      drill.to(start + way * (double(n) / steps));
      const Vector3d& at = drill.burr();
      if (std::min(at.x(), before.x()) < -kBetween || std::max(at.x(), before.x()) > kBetween) continue;
      cut += channelArea(r - 0.5 * (at.z() + before.z()), r) * (at.x() - before.x());
      by_law += drill.volumeByLaw() - law_before;
      if (first == 0) first = drill.trial().mark() - 1;
      end = drill.trial().mark();
    }
    if (with.tangential == 0) law = std::max(law, percentOff(cut, by_law));
    feed_step = std::max(feed_step, largestFeedStep(std::span(drill.trial().rows()).subspan(first, end - first)));
    drill.hold(300);
    late = std::max(late, drill.force());
    found.look(drill, with, out);
  });
  out.add("volume off Preston's law", "%", law, kLawPass);
  out.add("step of the force beyond the hand's own, at constant feed", "mN", feed_step, kFeedStepPass);
  out.add("force once it is out", "N", late, 1e-6);
  found.addTo(out);
  return out;
}

/// F39: through a wall of 0.2 mm, at up to 40 degrees, and back. Behind the wall the material ends at once.
Outcome breakThrough(ScenarioContext& context, Mode mode) {
  Outcome out;
  CutFigures found;
  double caught = 0, late = 0;
  int held = 0;
  eachRun(context, 39, 0.3, 3, [&](Drilling with, Random& random) {
    with.rate /= 2;
    Drill drill(context, mode, "plate_0.2", with);
    drill.tilt = randomTilt(random, 40);
    const Vector3d axis = drill.tilt * kUp, middle(random.uniform(-2, 2), random.uniform(-2, 2), 0);
    const Vector3d start = middle + (0.1 + with.radius + kApproach) / axis.z() * axis;
    drill.begin(start);
    drill.feed(-((start - middle).norm() + 0.1) * axis, with.feed, with.pressure);
    drill.moveTo(middle - 5 * with.radius * axis, with.feed);
    drill.hold(50);
    held += mode == Mode::Constrained && drill.burr().z() > -with.radius;
    caught = std::max(caught, drill.comeOut(start, -axis));
    late = std::max(late, drill.force());
    found.look(drill, with, out);
  });
  out.add("force once it is out", "N", late, 1e-6);
  found.addTo(out);
  out.add("force that holds the tool back as it comes out", "N", caught, kCaughtPass);
  out.figures.back().informative = true;
  out.add("runs in which the wall was not cut through", "1", held, 0);
  out.figures.back().informative = true;
  return out;
}

/// F40: the burr in the hole that it has made, held at the handle, which tilts by up to 20 degrees and moves by up to
/// 0.5 mm aside. In half of the runs the spindle rests meanwhile. Then it comes out along the hole.
Outcome tiltedInHole(ScenarioContext& context, Mode mode) {
  constexpr double kHandle = 15;
  Outcome out;
  CutFigures found;
  double caught = 0, late = 0, removed = 0;
  eachRun(context, 40, 0.3, 3, [&](const Drilling& with, Random& random) {
    Drill drill(context, mode, "small_block", with, kHandle);
    const Vector3d start = with.start(random);
    drill.begin(start);
    drill.feed(-(kApproach + random.uniform(0.7, 2)) * kUp, with.feed, kAhead);
    drill.release();
    const Vector3d bottom = drill.burr();
    const double before = drill.removed();
    drill.spin(with.is_spun_out);
    Vector3d hand = drill.hand();
    for (int turn = 0; turn < 5; ++turn) {
      const Quaternion tilt = randomTilt(random, 20);
      const Vector3d to = bottom + Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3));
      for (int n = 0; n < 200; ++n) {
        drill.tilt = drill.tilt.slerp(0.02, tilt);
        drill.to(hand += 0.02 * (to - hand));
      }
    }
    for (int n = 0; n < 500; ++n) {
      drill.tilt = drill.tilt.slerp(0.03, kUpright);
      drill.to(hand += 0.03 * (bottom - hand));
    }
    drill.tilt = kUpright;
    drill.to(bottom);
    if (!with.is_spun_out) removed = std::max(removed, drill.removed() - before);
    const double back = drill.comeOut(start, -kUp);
    if (!with.is_spun_out && with.tangential == 0) caught = std::max(caught, back);
    if (with.tangential == 0) late = std::max(late, drill.force());  // a burr that rubs makes a bent hole
    found.look(drill, with, out);
  });
  out.add("volume removed while the spindle rests", "mm3", removed, 0);
  out.add("force that holds a burr back that does not spin, as it comes out", "N", caught, kCaughtPass);
  out.add("force once it is out", "N", late, 1e-6);
  found.addTo(out);
  return out;
}

/// F41: while the burr is fed into the block, the spindle stops twice for up to 300 ms, and the hand moves on by up to
/// 1 mm meanwhile.
Outcome spindleStops(ScenarioContext& context, Mode mode) {
  Outcome out;
  CutFigures found;
  double removed = 0, way = 0, law = 0, late = 0;
  eachRun(context, 41, 0.3, 3, [&](const Drilling& with, Random& random) {
    Drill drill(context, mode, "small_block", with);
    const Vector3d start = with.start(random);
    drill.begin(start);
    drill.feed(-kApproach * kUp, with.feed, kAhead);
    for (int stop = 0; stop < 2; ++stop) {
      drill.feed(-random.uniform(0.3, 0.8) * kUp, with.feed, kAhead);
      drill.spin(false);
      const double before = drill.removed();
      const Vector3d at = drill.burr();
      const int steps = std::min(300, static_cast<int>(random.uniform(50, 1000) / with.feed));
      for (int n = 0; n < steps; ++n) {
        drill.to(drill.hand() - with.feed / 1000 * kUp);
        if (mode == Mode::Constrained) way = std::max(way, (drill.burr() - at).norm());
      }
      removed = std::max(removed, drill.removed() - before);
      drill.spin(true);
    }
    drill.feed(-0.3 * kUp, with.feed, kAhead);
    if (with.tangential == 0) law = std::max(law, percentOff(drilled(with.radius - drill.burr().z(), with.radius), drill.volumeByLaw()));
    drill.release();
    drill.spin(with.is_spun_out);
    (void)drill.comeOut(start, -kUp);
    late = std::max(late, drill.force());
    found.look(drill, with, out);
  });
  out.add("volume removed while the spindle rests", "mm3", removed, 0);
  out.add("way of the burr while the spindle rests", "mm", way, kWallPass);
  out.add("volume off Preston's law", "%", law, kLawPass);
  out.add("force once it is out", "N", late, 1e-6);
  found.addTo(out);
  return out;
}

constexpr double kFastestEnamel = 30;  // the pulp yields 30 times as fast, and 1000 mm/(N s) is the limit of a scene

/// Of F42, below the enamel, whose rate is `enamel`: dentine, a lesion in it, and the pulp. Their faces are level, so
/// that all of the burr meets the next layer at once.
std::vector<runtime::CutLayer> layersBelow(double enamel) {
  const auto layer = [&](const Vector3d& low, const Vector3d& high, double share) {
    return runtime::CutLayer{std::make_shared<const TriangleMesh>(box(low, high)), share * enamel};
  };
  return {layer({-2.8, -3.8, -5.8}, {2.8, 3.8, -0.8}, 3), layer({-2, -2, -1.8}, {2, 2, -1}, 9),
          layer({-2.5, -3.5, -5.5}, {2.5, 3.5, -2.1}, 30)};
}

/// F42: from enamel through dentine and a lesion into the pulp, at up to 20 degrees, and back.
Outcome throughLayers(ScenarioContext& context, Mode mode) {
  Outcome out;
  CutFigures found;
  double late = 0;
  int unreached = 0;
  eachRun(context, 42, 0.3, 3, [&](Drilling with, Random& random) {
    with.rate = std::min(with.rate, kFastestEnamel);
    Drill drill(context, mode, "small_block", with, 0, layersBelow(with.rate));
    drill.tilt = randomTilt(random, 20);
    const Vector3d axis = drill.tilt * kUp, middle(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), 0);
    const Vector3d start = middle + (with.radius + kApproach) / axis.z() * axis;
    drill.begin(start);
    drill.feed(-(2.2 + (start - middle).norm()) * axis, with.feed, kAhead);
    drill.release();
    unreached += mode == Mode::Constrained && drill.trial().removedOf(3) == 0;
    (void)drill.comeOut(start, -axis);
    late = std::max(late, drill.force());
    found.look(drill, with, out);
  });
  out.add("force once it is out", "N", late, 1e-6);
  found.addTo(out);
  out.add("runs that did not reach the pulp", "1", unreached, 0);
  out.figures.back().informative = true;
  return out;
}

/// F43: the hand of a tool whose burr spins in its hole jumps by 5 mm in any direction, and back 60 ms later, six
/// times.
Outcome jumpWhileSpinning(ScenarioContext& context, Mode mode) {
  constexpr double kJump = 5;
  Outcome out;
  CutFigures found;
  double late = 0;
  eachRun(context, 43, 0.3, 3, [&](const Drilling& with, Random& random) {
    Drill drill(context, mode, "small_block", with);
    const Vector3d start = with.start(random);
    drill.begin(start);
    drill.feed(-(kApproach + random.uniform(0.5, 2)) * kUp, with.feed, kAhead);
    const Vector3d bottom = drill.burr();
    for (int jump = 0; jump < 6; ++jump) {
      drill.to(bottom + kJump * (randomTurn(random) * kUp));
      drill.hold(60);
      drill.to(bottom);
      drill.hold(60);
    }
    (void)drill.comeOut(start, -kUp);
    drill.hold(100);
    late = std::max(late, drill.force());
    found.look(drill, with, out);
  });
  found.addTo(out);
  out.add("force at the end", "N", late, 0);  // of a tool that a jump has put beside the block
  out.figures.back().informative = true;
  return out;
}

Scenario cutting(std::string id, std::string alias, std::string title, std::function<Outcome(ScenarioContext&, Mode)> run) {
  return {std::move(id), std::move(alias), std::move(title), std::move(run), false};
}

}  // namespace

std::vector<Scenario> cuttingScenarios() {
  return {cutting("F37", "plunge", "A burr pressed straight into a block", plunge),
          cutting("F38", "side_cut", "A channel along a face", sideCut),
          cutting("F39", "break_through", "Through a wall of 0.2 mm", breakThrough),
          cutting("F40", "own_hole", "A burr tilted in its own hole", tiltedInHole),
          cutting("F41", "spindle", "A spindle that stops in the material", spindleStops),
          cutting("F42", "layers", "Through a lesion to the pulp", throughLayers),
          cutting("F43", "tool_jump", "A tool that jumps 5 mm while it spins", jumpWhileSpinning)};
}

}  // namespace spheretree::player
