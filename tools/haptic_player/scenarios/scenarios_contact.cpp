// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of contact: depth, ripple, edges, jumps. Distances in mm, speeds in mm/s.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "quantile.h"
#include "scenarios/scenario_run.h"

namespace spheretree::player {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const Eigen::Vector3d kProbeReference(0, 0, 60);  // the probe's reference point, 60 from its tip

/// Headings of F2's paths over the middle of the slab [rad].
constexpr std::array kRippleHeadings{0.13, 0.13 + 45 * kDegree, 0.13 + 90 * kDegree, 0.13 + 135 * kDegree};

void addPenetrations(Outcome& out, const ScenarioRun& trial) {
  out.add("penetration of leaf spheres", "mm", trial.leafPenetration(), kPenetrationPass);
  out.add("penetration of meshes", "mm", trial.meshPenetration(), kPenetrationPass);
}

// F1: a cube is pressed 40 deep into a block and dragged. It reveals rows of the far side and growing lists.
Outcome deep(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun::Options options;
  options.mesh_spacing = 2;
  const Body &cube = context.bodies.get("cube"), &block = context.bodies.get("block");
  ScenarioRun trial(cube, {{&block, {}}}, mode, options);
  const double start = 14;
  trial.to({{-20, 0, start}, kUpright});
  trial.moveTo({-20, 0, 9}, 50);
  const std::size_t shallow_begin = trial.work().size();
  trial.moveTo({-20, 0, 8}, 50);
  const std::size_t shallow_end = trial.work().size();
  trial.moveTo({-20, 0, -29}, 50);
  const std::size_t deep_begin = trial.work().size();
  trial.moveTo({-20, 0, -30}, 50);
  const std::size_t deep_end = trial.work().size();
  for (int n = 0; n < 1000; ++n) trial.to(trial.last().haptic);
  const std::size_t drag = trial.mark();
  trial.moveTo({20, 0, -30}, 50);
  const auto workOf = [&](std::size_t begin, std::size_t end) {
    const std::vector<std::uint32_t> work(trial.work().begin() + static_cast<std::ptrdiff_t>(begin),
                                          trial.work().begin() + static_cast<std::ptrdiff_t>(end));
    return static_cast<double>(tool::quantile(work, 0.5));
  };
  addPenetrations(out, trial);
  out.add("L-ratio while pressed and dragged", "1", std::max(largestLRatio(trial.since(0), {}), largestLRatio(trial.since(drag), {})),
          1.01);
  out.add("work at 40 mm over work at 1 mm", "1", workOf(deep_begin, deep_end) / std::max(1.0, workOf(shallow_begin, shallow_end)), 1.5);
  out.add("processor time of a step, p99.9", "us", trial.times().quantile(0.999), 500);
  out.add("processor time of a step, max", "us", trial.times().largest(), 1000);
  out.note = "The face is that of spheres with an overhang of at most " + text(leafOverhang(block)) + " mm.";
  trial.finish(out);
  return out;
}

struct Ripple {
  double lateral = 0, normal = 0, tilt = 0;  // [mN/N], [mN], [degree]
};

// 1 N along the four paths over a slab, in both directions, or the first `ways` of these eight.
Ripple rippleOf(ScenarioRun& trial, int ways) {
  const auto slide = [&](double heading, double z, double speed) {
    const Eigen::Vector3d way(std::cos(heading), std::sin(heading), 0);
    trial.restart();
    trial.to({-30 * way + Eigen::Vector3d(0, 0, 12), kUpright});
    trial.moveTo(-30 * way + Eigen::Vector3d(0, 0, z), 200);
    for (int n = 0; n < 20; ++n) trial.to(trial.last().haptic);
    const std::size_t mark = trial.mark();
    trial.moveTo(30 * way + Eigen::Vector3d(0, 0, z), speed);
    return mark;
  };
  const auto meanForce = [&](std::span<const RecordedStep> rows) {
    double sum = 0;
    for (const RecordedStep& row : rows) sum += row.wrench.force.z();
    return sum / static_cast<double>(rows.size());
  };
  Ripple out;
  for (std::size_t k = 0; k < static_cast<std::size_t>(ways); ++k) {
    const double heading = kRippleHeadings[k % 4] + (k < 4 ? 0 : std::numbers::pi), speed = std::array{10.0, 50.0, 100.0}[k % 3];
    // Finds the height at which the mean normal force is 1 N.
    double z = 5;
    z += meanForce(trial.since(slide(heading, z, 100))) - 1;
    const auto rows = trial.since(slide(heading, z, speed));
    const double mean = meanForce(rows);
    double low = 1e9, high = -1e9;
    for (const RecordedStep& row : rows) {
      const double side = row.wrench.force.head<2>().norm();
      out.lateral = std::max(out.lateral, 1000 * side / mean);
      out.tilt = std::max(out.tilt, std::atan2(side, row.wrench.force.z()) / kDegree);
      low = std::min(low, row.wrench.force.z());
      high = std::max(high, row.wrench.force.z());
    }
    out.normal = std::max(out.normal, 1000 * (high - low));
  }
  return out;
}

// The same number of leaves, distributed in two ways: concentrated where the scenario works, as by a scene's regions of
// work; and evenly, as published.
struct Detail {
  const char *suffix, *label;
  PlacedBody body(ScenarioContext& context, const char* name, const Eigen::Vector3d& place = Eigen::Vector3d::Zero()) const {
    return {&context.bodies.get(std::string(name) + suffix), {place, kUpright}};
  }
};
constexpr const char *kAtWork = ", detail where the tool goes", *kEven = ", even detail";

void add(Outcome& out, const Detail& detail, const char* quantity, const char* unit, double value, double pass, bool is_judged = true) {
  out.add(std::string(quantity) + detail.label, unit, value, pass);
  out.figures.back().informative = !is_judged;
}

double workOverhang(const Body& body) { return static_cast<double>(body.tree.provenance.work_overhang_mm); }
std::string leavesOf(const Body& body) { return std::to_string(body.tree.statistics.back().sphere_count) + " leaves"; }

// F2: lateral and normal ripple of a plane of 512 leaves under 1 N, 8 headings. Evenly distributed leaves suffice for a
// flat face.
Outcome ripple(ScenarioContext& context, Mode mode) {
  Outcome out;
  double deepest = 0;
  for (const Detail& detail : {Detail{"", kEven}, Detail{"_work", kAtWork}}) {
    const bool is_at_work = detail.label == kAtWork;
    const PlacedBody placed = detail.body(context, "slab");
    const Body& slab = *placed.body;
    ScenarioRun trial(context.bodies.get("ball"), {placed}, mode);
    const Ripple r = rippleOf(trial, context.repetitions(8, 3));
    add(out, detail, "lateral ripple", "mN/N", r.lateral, 20, !is_at_work);
    add(out, detail, "normal ripple, peak to peak", "mN", r.normal, 20, !is_at_work);
    add(out, detail, "largest tilt of the force", "degree", r.tilt, 1.1, !is_at_work);
    deepest = std::max(deepest, trial.leafPenetration());
    if (detail.label == kEven) {
      out.note = "100 x 100 mm. Even detail: " + leavesOf(slab) + " within " + text(leafOverhang(slab)) + " mm.";
      trial.finish(out);
    } else if (is_at_work) {
      out.note += " Detail where the tool goes: " + leavesOf(slab) + " within " + text(workOverhang(slab)) + " mm there.";
    }
  }
  out.add("penetration of leaf spheres", "mm", deepest, kPenetrationPass);
  return out;
}

struct OverEdge {
  double travel = 0, error = 0;  // additional travel while the force turns; largest distance from the exact solution [mm]
};

// A ball of radius 5 slides over the edge of a cube, which is on the y axis.
OverEdge slideOverEdge(ScenarioRun& trial) {
  // 2 N: along the surface 2 below the exact offset surface.
  const double depth = 2, radius = 5 - depth, speed = 10;
  std::vector<Eigen::Vector3d> path;
  const auto line = [&](Eigen::Vector3d a, const Eigen::Vector3d& b) {
    const int n = static_cast<int>((b - a).norm() / (speed / 1000));
    for (int i = 0; i < n; ++i) path.push_back(a + (b - a) * (double(i) / n));
  };
  line({-6, 0, 7}, {-6, 0, radius});
  line({-6, 0, radius}, {0, 0, radius});
  const int turn_steps = static_cast<int>(radius * std::numbers::pi / 2 / (speed / 1000));
  for (int i = 0; i < turn_steps; ++i) {
    const double a = std::numbers::pi / 2 * i / turn_steps;
    path.emplace_back(radius * std::sin(a), 0, radius * std::cos(a));
  }
  line({radius, 0, 0}, {radius, 0, -6});
  const auto turning = [](const Eigen::Vector3d& f) {
    const double a = std::atan2(f.x(), f.z()) / kDegree;
    return f.norm() > 0.1 && a > 10 && a < 80;
  };
  OverEdge out;
  for (const Eigen::Vector3d& p : path) {
    const runtime::StepResult r = trial.to({p, kUpright});
    const Eigen::Vector3d exact = offsetEdge(p, 5);
    out.error = std::max(out.error, (r.graphic.position - exact).norm());
    out.travel += (turning(r.wrench.force) - turning(exact - p)) * speed / 1000;
  }
  out.travel = std::abs(out.travel);
  return out;
}

// Largest distance from its exact position of a ball of radius 1 that slides along the groove of 60 degrees under 2 N
// [mm].
double slideInGroove(ScenarioRun& trial) {
  double error = 0;
  trial.to({{0, -5, 8}, kUpright});
  trial.moveTo({0, -5, 0}, 50);  // 2 below its exact position
  const std::size_t mark = trial.mark();
  trial.moveTo({0, 5, 0}, 10);
  for (const RecordedStep& row : trial.since(mark))
    error = std::max(error, (row.graphic.position - offsetGroove(row.haptic.position, 1, 30 * kDegree)).norm());
  return error;
}

// F3: how sharp an edge and a groove feel, compared with the exact solutions for a ball.
Outcome edges(ScenarioContext& context, Mode mode) {
  Outcome out;
  double deepest = 0;
  for (const Detail& detail : {Detail{"_work", kAtWork}, Detail{"", kEven}}) {
    const bool is_at_work = detail.label == kAtWork;
    const PlacedBody cube_there =
                         detail.body(context, "cube", {-10, 0, -10}),  // its edge is on the y axis, and the solid is where x < 0 and z < 0
        groove_there = detail.body(context, "groove");
    const Body &cube = *cube_there.body, &groove = *groove_there.body;
    ScenarioRun at_edge(context.bodies.get("ball"), {cube_there}, mode), in_groove(context.bodies.get("small_ball"), {groove_there}, mode);
    const OverEdge over = slideOverEdge(at_edge);
    const double close = is_at_work ? 0.1 : 0.02;  // 0.1 mm needs detailed leaves; a skin has the mesh itself
    add(out, detail, "extra travel while the force turns from 10 to 80 degrees", "mm", over.travel, 0.5);
    add(out, detail, "position error over a cube's edge", "mm", over.error, close);
    add(out, detail, "position error in a 60 degree groove", "mm", slideInGroove(in_groove), close);
    deepest = std::max({deepest, at_edge.leafPenetration(), in_groove.leafPenetration()});
    if (is_at_work) {
      out.note = "Detail where the tool goes: a cube of " + leavesOf(cube) + " and a groove of " + leavesOf(groove) + " within " +
                 text(workOverhang(cube)) + " and " + text(workOverhang(groove)) +
                 " mm there; a groove of half angle 30 degrees doubles it.";
      in_groove.finish(out);
    } else if (detail.label == kEven) {
      out.note += " Even detail: within " + text(leafOverhang(cube)) + " and " + text(leafOverhang(groove)) + " mm.";
    }
  }
  out.add("penetration of leaf spheres", "mm", deepest, kPenetrationPass);
  return out;
}

// The probe is swept over a ridge whose crest is on the y axis.
void sweepOverRidge(ScenarioRun& trial) {
  const Eigen::Vector3d up = kProbeReference;
  trial.to({up + Eigen::Vector3d(-6, 0, 1), kUpright});
  trial.moveTo(up + Eigen::Vector3d(-6, 0, -6), 20);
  trial.moveTo(up + Eigen::Vector3d(-2, 0, -2), 20);
  trial.moveTo(up + Eigen::Vector3d(6, 0, -2), 20);
}

constexpr double kFineReference = 24;  // distance of the reference point of the fine probe from its tip

void sweepInSulcus(ScenarioRun& trial) {
  const Eigen::Vector3d at(0, 0, kFineReference);
  trial.to({at + Eigen::Vector3d(-3, 0, 1), kUpright});
  trial.moveTo(at + Eigen::Vector3d(-3, 0, -1.5), 20);
  trial.moveTo(at + Eigen::Vector3d(0, 0, -1.5), 20);
  trial.moveTo(at + Eigen::Vector3d(0, 0, -4.5), 20);
  trial.moveTo(at + Eigen::Vector3d(1.5, 0, -4.5), 20);
  trial.moveTo(at + Eigen::Vector3d(-1.5, 0, -4.5), 20);
  trial.moveTo(at + Eigen::Vector3d(0, 3, -3), 20);
  trial.moveTo(at + Eigen::Vector3d(0, 3, 2), 20);
}

struct OverCrown {
  double force = 0, torque = 0, off = 0;  // largest steps; share of the time off the tooth
};

// From side to side over cusps and fissures of a crown, 1 to 4 below its highest point, in four headings.
OverCrown sweepOverCrown(ScenarioRun& trial, const Eigen::AlignedBox3d& tooth) {
  const Eigen::Vector3d top(tooth.center().x(), tooth.center().y(), tooth.max().z() + kFineReference);
  OverCrown out;
  for (int k = 0; k < 4; ++k) {
    const double heading = 0.4 + k * std::numbers::pi / 4;
    const Eigen::Vector3d way = 0.4 * tooth.sizes().head<2>().minCoeff() * Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
    const Eigen::Vector3d down(0, 0, -1 - k);
    trial.restart();
    const std::size_t start = trial.mark();
    trial.to({top - way + Eigen::Vector3d(0, 0, 1), kUpright});
    trial.moveTo(top - way + down, 20);
    const std::size_t mark = trial.mark();
    trial.moveTo(top + way + down, 20);
    out.force = std::max(out.force, largestForceJump(trial.since(start), {}));
    out.torque = std::max(out.torque, largestTorqueJump(trial.since(start), {}));
    const auto rows = trial.since(mark);
    const auto off = std::count_if(rows.begin(), rows.end(), [](const RecordedStep& row) { return row.wrench.force.norm() == 0; });
    out.off += 0.25 * static_cast<double>(off) / static_cast<double>(rows.size());
  }
  return out;
}

// F5: the probe is swept over a ridge, over the corner of a box, through a sulcus, and over a molar.
Outcome jumps(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &probe = context.bodies.get("probe"), &fine = context.bodies.get("fine_probe"), &cube = context.bodies.get("cube");
  ScenarioRun::Options options, fine_options;
  options.reference_point = kProbeReference;
  fine_options.reference_point = {0, 0, kFineReference};
  const Body& sulcus = context.bodies.get("sulcus");
  ScenarioRun over_ridge(probe, {{&context.bodies.get("ridge"), {}}}, mode, options), in_sulcus(fine, {{&sulcus, {}}}, mode, fine_options);
  sweepOverRidge(over_ridge);
  sweepInSulcus(in_sulcus);
  out.add("L-ratio over a convex ridge", "1", largestLRatio(over_ridge.since(0), {}), 1.01);
  out.add("force step in the sulcus over max(0.1 N, 7 %)", "1", largestForceJump(in_sulcus.since(0), {}), 1);
  out.add("torque step in the sulcus over max(5 N mm, 13 %)", "1", largestTorqueJump(in_sulcus.since(0), {}), 1);
  out.note =
      "Where the hand is deep below convex spheres the nearest point of the model moves faster than the hand. The sulcus is 1.5 mm wide: "
      "the probe there is 0.6 mm thick, and the walls stand off by up to " +
      text(leafOverhang(sulcus)) + " mm.";
  const Eigen::Vector3d up = kProbeReference;
  ScenarioRun over_corner(probe, {{&cube, {}}}, mode, options);
  over_corner.to({up + Eigen::Vector3d(6, 6, 11.5), kUpright});
  over_corner.moveTo(up + Eigen::Vector3d(6, 6, 9), 20);
  over_corner.moveTo(up + Eigen::Vector3d(14, 14, 9), 20);
  out.add("L-ratio over a box corner", "1", largestLRatio(over_corner.since(0), {}), 1.01);
  const Body& molar = context.bodies.get("molar");
  ScenarioRun over_crown(fine, {{&molar, {}}}, mode, fine_options);
  Eigen::AlignedBox3d tooth;
  for (const Eigen::Vector3d& p : BodyLibrary::mesh("molar").positions) tooth.extend(p);
  const OverCrown crown = sweepOverCrown(over_crown, tooth);
  out.add("force step over a molar's crown over max(0.1 N, 7 %)", "1", crown.force, 1);
  out.add("torque step over a molar's crown over max(5 N mm, 13 %)", "1", crown.torque, 1);
  out.add("share of the way over the crown off the tooth", "%", 100 * crown.off, 50);
  out.add(
      "penetration of leaf spheres", "mm",
      std::max({over_ridge.leafPenetration(), in_sulcus.leafPenetration(), over_corner.leafPenetration(), over_crown.leafPenetration()}),
      kPenetrationPass);
  over_ridge.finish(out);
  return out;
}

// F8: large rotations in one cycle, with the tip on a plane.
Outcome turns(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun::Options options;
  options.reference_point = kProbeReference;
  options.mesh_spacing = 1;
  const Body &probe = context.bodies.get("probe"), &slab = context.bodies.get("slab");
  ScenarioRun trial(probe, {{&slab, {}}}, mode, options);
  double slowest = 0;
  const double top = leafOverhang(slab);
  const Eigen::Vector3d rest(0, 0, 60 - 0.5);
  const auto settle = [&] {  // steps until the graphic tool is within 0.01 mm and 0.01 degree of its final pose
    std::vector<Configuration> poses;
    const Configuration haptic = trial.last().haptic;
    for (int n = 0; n < 60; ++n) poses.push_back(trial.to(haptic).graphic);
    int needed = 0;
    for (int n = 0; n < 60; ++n) {
      const Displacement d = displacementBetween(poses[static_cast<std::size_t>(n)], poses.back());
      if (d.translation.norm() > 0.01 || d.rotation.norm() > 0.01 * kDegree) needed = n + 2;
    }
    slowest = std::max(slowest, double(needed));
  };
  for (const double degrees : {0.5, 5.0, 30.0, 90.0})
    for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.6, 0.8, 0), Eigen::Vector3d(0, 0, 1)}) {
      trial.restart();
      trial.to({rest + Eigen::Vector3d(0, 0, 1.5 + top), kUpright});
      trial.moveTo(rest, 100);
      trial.to({rest, rotationOf(axis * (degrees * kDegree))});
      settle();
    }
  for (const double rate : {2.0, 10.0, 30.0}) {
    trial.restart();
    trial.to({rest + Eigen::Vector3d(0, 0, 1.5 + top), kUpright});
    trial.moveTo(rest, 100);
    for (double a = 0; a < std::numbers::pi / 2; a += rate / 1000) trial.to({rest, rotationOf({a, 0, 0})});
    settle();
  }
  addPenetrations(out, trial);
  out.add("cycles until the answer stands", "1", slowest, 10);
  trial.finish(out);
  return out;
}

// F13: a contact that begins between two cycles.
Outcome born(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun::Options options;
  options.mesh_spacing = 0.5;
  const Body &ball = context.bodies.get("ball"), &slab = context.bodies.get("slab");
  ScenarioRun trial(ball, {{&slab, {}}}, mode, options);
  double first = 0;
  Random random(13);
  for (int run = 0; run < context.repetitions(200, 20); ++run) {
    context.progress.check();
    const double tilt = run % 2 ? 85 * kDegree : 0, heading = random.uniform(0, 6.28);
    const Eigen::Vector3d way(std::sin(tilt) * std::cos(heading), std::sin(tilt) * std::sin(heading), -std::cos(tilt));
    trial.restart();
    Eigen::Vector3d p = Eigen::Vector3d(random.uniform(-10, 10), random.uniform(-10, 10), 5) - way * random.uniform(20, 21);
    trial.to({p, kUpright});
    for (int n = 0; n < 24; ++n) {
      p += way;  // 1 m/s
      const runtime::StepResult r = trial.to({p, kUpright});
      if (r.active == 0) continue;
      first = std::max(first, trial.leafDepth(r.graphic));
      for (int k = 0; k < 5; ++k) trial.to({p, kUpright});
      break;
    }
  }
  out.add("penetration in the first cycle of contact", "mm", first, kPenetrationPass);
  addPenetrations(out, trial);
  trial.finish(out);
  return out;
}

// F14: into concavities and out again.
Outcome concave(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &ball = context.bodies.get("ball"), &small = context.bodies.get("small_ball");
  double left = 0, deepest = 0;
  const auto freedom = [&](ScenarioRun& trial, const Configuration& free) {  // the distance between the two tools five cycles later
    for (int n = 0; n < 5; ++n) trial.to(free);
    const Displacement d = displacementBetween(trial.last().haptic, trial.last().graphic);
    left = std::max(left, d.translation.norm() + 31.6 * d.rotation.norm());
    deepest = std::max(deepest, trial.leafPenetration());
  };
  const Body& corner = context.bodies.get("corner");
  for (const double angle : {-44.0, 0.0, 44.0}) {
    ScenarioRun trial(ball, {{&corner, {}}}, mode);
    const Eigen::Vector3d out_way(std::sin((45 + angle) * kDegree), 0, std::cos((45 + angle) * kDegree));
    trial.to({{12, 0, 12}, kUpright});
    trial.moveTo({3, 0, 3}, 50);
    trial.moveTo(Eigen::Vector3d(3, 0, 3) + 12 * out_way, 50);
    freedom(trial, {{14, 0, 14}, kUpright});
  }
  ScenarioRun::Options options;
  options.reference_point = kProbeReference;
  ScenarioRun hole(context.bodies.get("probe"), {{&context.bodies.get("blind_hole"), {}}}, mode, options);
  hole.to({kProbeReference + Eigen::Vector3d(0, 0, 2), kUpright});
  hole.moveTo(kProbeReference + Eigen::Vector3d(0, 0, -6), 20);
  double lowest = 0;
  for (const RecordedStep& row : hole.rows()) lowest = std::min(lowest, row.graphic.position.z() - 60);
  hole.moveTo(kProbeReference + Eigen::Vector3d(0, 0, 3), 20);
  freedom(hole, hole.last().haptic);
  // Without friction, a circle on the bowl's floor returns the energy that it takes.
  ScenarioRun bowl(small, {{&context.bodies.get("bowl"), {}}}, mode);
  const auto at = [](double turn) { return Eigen::Vector3d(4 * std::cos(turn), 4 * std::sin(turn), -7.5); };
  bowl.to({{4, 0, 0}, kUpright});
  bowl.moveTo(at(0), 20);
  const auto circle = [&] {
    for (int n = 1; n <= 1000; ++n) bowl.to({at(2 * std::numbers::pi * n / 1000), kUpright});
  };
  circle();
  const std::size_t mark = bowl.mark();
  circle();
  double energy = 0, stored = 0;
  const auto rows = bowl.since(mark - 1);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const Eigen::Vector3d force =
        0.5 * (rows[i - 1].wrench.force + rows[i].wrench.force);  // trapezoidal rule, so that the sampling itself loses no energy
    energy -= force.dot(rows[i].haptic.position - rows[i - 1].haptic.position);
    stored = std::max(stored, 0.5 * rows[i].wrench.force.squaredNorm());
  }
  deepest = std::max(deepest, bowl.leafPenetration());
  out.add("distance of the tools after return to free space", "mm", left, 1e-6);
  out.add("energy lost or gained in a circle over the stored", "1", std::abs(energy) / stored, 0.01);
  out.add("penetration of leaf spheres", "mm", deepest, kPenetrationPass);
  out.add("part of a blind hole 5 deep that is not reached", "mm", 5 + lowest, 0.5);
  out.figures.back().informative = true;
  out.note = "The hole has 0.2 mm of play; the leaves around it reach in by up to " + text(leafOverhang(context.bodies.get("blind_hole"))) +
             " mm, so that the model's hole is narrower.";
  hole.finish(out);
  return out;
}

// F17: the error of a row's linearisation if it starts inside.
Outcome insideRows(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body& small = context.bodies.get("small_ball");
  ScenarioRun::Options options;
  options.contact = runtime::ContactSurface::Leaves;  // rows of leaves, which are all that a tool inside feels
  ScenarioRun trial(small, {{&small, {}}}, mode, options);
  const auto leaf = [&] {
    for (std::size_t n = 0; n < small.tree.nodeCount(); ++n)
      if (small.tree.isLeaf(n)) return small.tree.cover[n];
    return small.tree.cover[0];
  }();
  const double touch = 2 * static_cast<double>(leaf.radius) / trial.scale();
  double error = 0;
  for (int k = 0; k <= 19; ++k) {
    const Configuration inside{{0.6 * 0.1 * k, 0, 0.8 * 0.1 * k}, kUpright};
    trial.resetTo(inside);
    runtime::StepResult r = trial.to(inside);
    if (mode == Mode::Constrained)
      for (int n = 0; n < 9; ++n) r = trial.to(inside);
    if (!r.graphic.position.allFinite()) error = 1e9;
    error = std::max(error, std::abs(r.graphic.position.norm() - touch));
  }
  out.add("distance from touching after the correction", "mm", error, 1e-6);
  trial.finish(out);
  return out;
}

}  // namespace

std::vector<Scenario> contactScenarios() {
  return {{"F1", "deep", "Deep penetration", deep},
          {"F2", "ripple", "Planar ripple", ripple},
          {"F3", "edges", "Sharp edges rounded", edges},
          {"F5", "jumps", "Force jumps at contact switches", jumps},
          {"F8", "turns", "Linearisation of rotations", turns},
          {"F13", "born", "Contact born between cycles", born},
          {"F14", "concave", "Sticking in concavities", concave},
          {"F17", "inside", "Squared-distance rows from inside", insideRows, false}};
}

}  // namespace spheretree::player
