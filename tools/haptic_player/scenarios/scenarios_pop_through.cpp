// SPDX-License-Identifier: GPL-3.0-or-later
// F4: tools are driven through thin plates and a wire, at up to 2 m/s and in one jump. Distances in mm, speeds in mm/s.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "scenarios/scenario_run.h"

namespace spheretree::player {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// Points of a tool's axis, in tool axes, relative to the reference point.
std::vector<Eigen::Vector3d> axisPoints(bool is_probe) {
  if (!is_probe) return {Eigen::Vector3d::Zero()};
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= 16; ++i) points.emplace_back(0, 0, 0.3 + 39.4 * i / 16);
  return points;
}

/// Whether a point of the axis passed through the middle plane z = 0 within the plate.
bool crossesPlate(const std::vector<Eigen::Vector3d>& axis, const Configuration& a, const Configuration& b) {
  for (const Eigen::Vector3d& p : axis) {
    const Eigen::Vector3d from = a.orientation * p + a.position, to = b.orientation * p + b.position;
    if (!(from.z() > 0) || to.z() > 0) continue;
    const Eigen::Vector3d at = from + (to - from) * (from.z() / (from.z() - to.z()));
    if (at.head<2>().cwiseAbs().maxCoeff() < 20) return true;
  }
  return false;
}

struct PopThrough {
  int runs = 0, crossings = 0;
  double deepest = 0;
};

// One tool is driven through one plate of 40 x 40, `runs` times: to 30 beyond it at up to 2 m/s, and by 50 in one step.
void throughPlate(ScenarioContext& context, ScenarioRun& trial, bool is_probe, int runs, Random& random, PopThrough& sum) {
  constexpr std::array speeds{50.0, 500.0, 1000.0, 2000.0, 50'000.0};  // the last one: 50 mm in one step
  const std::vector<Eigen::Vector3d> axis = axisPoints(is_probe);
  for (int run = 0; run < runs; ++run) {
    // One run in twenty is slow: slow runs take most of the time and cross least often.
    const double speed = speeds[run % 20 == 0 ? 0 : 1 + static_cast<std::size_t>(run) % 4];
    const double tilt = random.uniform(0, 80) * kDegree, heading = random.uniform(0, 2 * std::numbers::pi);
    const Eigen::Vector3d way(std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), -std::cos(tilt));
    const Eigen::Vector3d target(random.uniform(-6, 6), random.uniform(-6, 6), 0);
    Quaternion orientation = kUpright;  // the probe comes with its tip first, within 30 degrees of its direction
    if (is_probe) orientation = rotationOf(Eigen::Vector3d(way.y(), -way.x(), 0).normalized() * -std::min(tilt, 30 * kDegree));
    const double before_target = (is_probe ? 6 : 12) / std::cos(tilt), total = before_target + 30;
    // Sideways only from 8 before the target to 8 beyond it, the rest straight down: a tool may slide around the edge
    // of the plate, even in one step.
    const double aslant = std::min(30.0, 8 / std::max(std::sin(tilt), 1e-3));
    const auto handAt = [&](double s) -> Eigen::Vector3d {
      const double sideways = std::clamp(s, -aslant, aslant);
      return target + way * sideways - Eigen::Vector3d(0, 0, s - sideways);
    };
    trial.restart();
    trial.to({handAt(-before_target), orientation});
    Configuration before = trial.last().graphic;
    const int steps = std::max(1, static_cast<int>(total / (speed / 1000)));
    for (int n = 1; n <= steps; ++n) {
      const runtime::StepResult r = trial.to({handAt(total * n / steps - before_target), orientation});
      if (crossesPlate(axis, before, r.graphic)) {
        ++sum.crossings;
        break;
      }
      before = r.graphic;
    }
    if (++sum.runs % 64 == 0) context.progress.check();
  }
  sum.deepest = std::max(sum.deepest, trial.leafPenetration());
}

/// The side on which the probe's axis passes the wire, the y axis, as a sign; 0 if they pass beyond an end of the probe
/// or too far from each other.
double sideOfWire(const Configuration& probe) {
  const Eigen::Vector3d along = probe.orientation * Eigen::Vector3d::UnitZ(), across = along.cross(Eigen::Vector3d::UnitY());
  if (across.norm() < 0.05) return 0;
  // The point of the probe's axis nearest to the wire, in the x, z plane.
  const Eigen::Vector2d p(probe.position.x(), probe.position.z()), d(along.x(), along.z());
  const double s = -p.dot(d) / d.squaredNorm();
  if (s < 0.3 || s > 39.7 || std::abs(probe.position.y() + s * along.y()) > 20) return 0;
  return probe.position.dot(across) / across.norm();
}

// A cube too wide to roll off, and a lying probe, are pressed over the wire.
void overWire(ScenarioContext& context, Mode mode, Random& random, PopThrough& sum) {
  constexpr std::array speeds{50.0, 500.0, 1000.0, 2000.0, 50'000.0};
  const Body& wire = context.bodies.get("wire");
  const Configuration along_y{{0, 0, 0}, rotationOf({std::numbers::pi / 2, 0, 0})};
  ScenarioRun cube(context.bodies.get("cube"), {{&wire, along_y}}, mode), probe(context.bodies.get("fine_probe"), {{&wire, along_y}}, mode);
  for (int run = 0; run < context.repetitions(800, 40); ++run) {
    const bool is_probe = run % 2 == 1;
    ScenarioRun& trial = is_probe ? probe : cube;
    const double speed = speeds[run % 40 < 2 ? 0 : 1 + static_cast<std::size_t>(run / 2) % 4], x = random.uniform(-2, 2),
                 y = random.uniform(-5, 5);
    const Quaternion lying = is_probe ? rotationOf({0, std::numbers::pi / 2, 0}) : kUpright;
    const Eigen::Vector3d at(is_probe ? x - 20 : x, y, 0);
    trial.restart();
    trial.to({at + Eigen::Vector3d(0, 0, 14), lying});
    const int steps = std::max(1, static_cast<int>(44 / (speed / 1000)));
    bool crossed = false;
    double before = sideOfWire(trial.last().graphic);
    for (int n = 1; n <= steps && !crossed; ++n) {
      const Configuration graphic = trial.to({at + Eigen::Vector3d(0, 0, 14 - 44.0 * n / steps), lying}).graphic;
      const double side = sideOfWire(graphic);
      crossed = is_probe ? side * before < 0 : graphic.position.z() < 0;
      before = side;
    }
    sum.crossings += crossed;
    if (++sum.runs % 64 == 0) context.progress.check();
  }
  sum.deepest = std::max({sum.deepest, cube.leafPenetration(), probe.leafPenetration()});
}

// F4: through plates and a wire.
Outcome popThrough(ScenarioContext& context, Mode mode) {
  Outcome out;
  Random random(4);
  const int runs = context.repetitions(10'000, 80);
  PopThrough plates, wires;
  for (const char* plate : {"plate_2", "plate_1", "plate_0.5", "plate_0.2"})
    for (const bool is_probe : {false, true}) {
      ScenarioRun::Options options;
      options.keep_rows = plate == std::string("plate_0.2") && !is_probe;
      ScenarioRun trial(context.bodies.get(is_probe ? "fine_probe" : "ball"), {{&context.bodies.get(plate), {}}}, mode, options);
      throughPlate(context, trial, is_probe, runs / 8, random, plates);
      if (options.keep_rows) trial.finish(out);
    }
  out.recording.resize(std::min<std::size_t>(out.recording.size(), 20'000));
  overWire(context, mode, random, wires);
  out.add("crossings of plates in " + std::to_string(plates.runs) + " runs", "1", plates.crossings, 0);
  out.add("crossings of a wire of 0.5 mm in " + std::to_string(wires.runs) + " runs", "1", wires.crossings, 0);
  out.add("penetration of leaf spheres", "mm", std::max(plates.deepest, wires.deepest), kPenetrationPass);
  return out;
}

}  // namespace

std::vector<Scenario> popThroughScenarios() { return {{"F4", "pop-through", "Pop-through of thin objects", popThrough}}; }

}  // namespace spheretree::player
