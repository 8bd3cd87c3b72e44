// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of numerical accuracy: rotations, rows, units.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "run/real_time.h"
#include "run/servo_loop.h"
#include "scenarios/scenario_run.h"
#include "search/find_pairs.h"
#include "state/step_memory.h"

namespace spheretree::player {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
const Eigen::Vector3d kProbeReference(0, 0, 60);

Quaternion randomRotation(Random& random) {
  for (;;) {
    const double w = random.uniform(-1, 1), x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
    const Quaternion q(w, x, y, z);
    if (q.squaredNorm() > 0.01 && q.squaredNorm() < 1) return q.normalized();
  }
}

Quaternion fromEuler(double gamma, double beta, double alpha) {
  return rotationOf({0, 0, alpha}) * rotationOf({0, beta, 0}) * rotationOf({gamma, 0, 0});
}

// F6: the pitch is swept through 90 degrees, with the probe's tip on a plane. The reference is the constrained result
// in a world rotated such that no angle is singular: a result that depends on the choice of axes differs from it.
Outcome euler(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun::Options options;
  options.reference_point = kProbeReference;
  const Body &probe = context.bodies.get("probe"), &slab = context.bodies.get("slab");
  const Quaternion turned = rotationOf({0.4, -0.9, 0.7});
  double translation = 0, rotation = 0, torque = 0, max_work = 0;
  for (const double spin : {0.0, 45.0, 170.0}) {
    ScenarioRun trial(probe, {{&slab, {}}}, mode, options);
    ScenarioRun reference(probe, {{&slab, {{0, 0, 0}, turned}}}, Mode::Constrained, options);
    const auto both = [&](const Configuration& pose) {
      const runtime::StepResult a = trial.to(pose);
      const runtime::StepResult b = reference.to({turned * pose.position, (turned * pose.orientation).normalized()});
      const Configuration back{turned.conjugate() * b.graphic.position, (turned.conjugate() * b.graphic.orientation).normalized()};
      const Displacement d = displacementBetween(a.graphic, back);
      translation = std::max(translation, d.translation.norm());
      rotation = std::max(rotation, d.rotation.norm() / kDegree);
      torque = std::max(torque, (a.wrench.torque - turned.conjugate() * b.wrench.torque).norm());
      max_work = std::max(max_work, double(a.work));
    };
    // Pitch beta about y tilts the probe's axis; the reference point moves such that the tip stays 0.3 below the
    // plane's top.
    const double depth = 0.3, from = 80 * kDegree, to = 100 * kDegree;
    const auto pose = [&](double beta, double above) {
      const Quaternion q = fromEuler(spin * kDegree, beta, spin * kDegree);
      const Eigen::Vector3d tip = q * Eigen::Vector3d(0, 0, -59);  // centre of the tip's ball
      // The lowest point of the probe, the tip or the far end, is at the prescribed height.
      const double low = std::min(tip.z(), (q * Eigen::Vector3d(0, 0, 39)).z()) - 1;
      return Configuration{{0, 0, -low - depth + above}, q};
    };
    for (double above = 3; above > 0; above -= 0.05) both(pose(from, above));
    for (double beta = from; beta < to; beta += 0.5e-3) both(pose(beta, 0));
    if (spin == 45.0) trial.finish(out);
  }
  out.add("difference of the pose from a solution in turned axes", "mm", translation, 0.01);
  out.add("orientation apart", "degree", rotation, 0.01);
  out.add("torque apart", "N mm", torque, 0.1);
  out.note = "Both solvers stop within 2e-5 mm of rest; 1e-4 degree of the probe is 0.002 N mm.";
  return out;
}

// F7: two full rotations about each axis in free space.
Outcome wrap(ScenarioContext& context, Mode mode) {
  Outcome out;
  ScenarioRun::Options options;
  options.reference_point = kProbeReference;
  ScenarioRun trial(context.bodies.get("probe"), {{&context.bodies.get("block"), {{500, 0, 0}, kUpright}}}, mode, options);
  double force = 0, torque = 0;
  for (int axis = 0; axis < 3; ++axis) {
    trial.restart();
    for (int n = 0; n <= 720; ++n) {
      const runtime::StepResult r = trial.to({{0, 0, 0}, rotationOf(Eigen::Vector3d::Unit(axis) * (n * kDegree))});
      force = std::max(force, r.wrench.force.norm());
      torque = std::max(torque, r.wrench.torque.norm());
    }
  }
  out.add("force in free space", "N", force, 1e-9);
  out.add("torque in free space", "N mm", torque, 1e-9);
  trial.finish(out);
  return out;
}

struct Leaf {
  std::uint32_t slot;
  Eigen::Vector3d centre;
  double radius;
};

std::vector<Leaf> leavesOf(const runtime::CompiledTree& tree) {
  std::vector<Leaf> leaves;
  for (std::uint32_t slot = 0; slot < tree.item.size(); ++slot)
    if (tree.item[slot] != runtime::kNoItem)
      leaves.push_back({slot, {tree.exact[slot][0], tree.exact[slot][1], tree.exact[slot][2]}, double(tree.spheres[slot].radius)});
  return leaves;
}

// F10: the pairs of the tree search against a test of every leaf with every leaf.
Outcome missedPairs(ScenarioContext& context, Mode mode) {
  Outcome out;
  Random random(10);
  int missed = 0, extra = 0;
  double max_tests = 0;
  const int poses = context.repetitions(100'000, 500);
  for (const auto& [tool_name, object_name] :
       {std::pair{"cube", "molar"}, std::pair{"dental_probe", "molar"}, std::pair{"cylinder", "groove"}}) {
    ScenarioRun trial(context.bodies.get(tool_name), {{&context.bodies.get(object_name), {}}}, mode);
    const runtime::CompiledScene& scene = trial.scene().compiled();
    const std::vector<Leaf> tool = leavesOf(scene.tool), object = leavesOf(scene.shapes[0].leaves);
    const double reach = 0.5 * (scene.tool.reach + scene.shapes[0].radius);
    std::vector<std::uint32_t> exact, found;
    for (int n = 0; n < poses; ++n) {
      const Configuration pose{{random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)},
                               randomRotation(random)};
      const runtime::PairSet set = runtime::findPairs(pose, 0, runtime::PairsOf::LeavesExactly, 1 << 30, trial.workspace().memory());
      if (set.coarse) continue;  // deep inside, where the list is full: inner nodes replace leaves
      exact.clear();
      const Eigen::Vector3d offset = pose.position - scene.objects[0].anchor;
      const Eigen::Matrix3d rotation = pose.orientation.toRotationMatrix();
      for (const Leaf& t : tool) {
        const Eigen::Vector3d c = rotation * t.centre + offset;
        if (c.norm() > scene.shapes[0].radius + t.radius + 1) continue;
        for (const Leaf& o : object) {
          const double touch = t.radius + o.radius;
          // Within rounding of the touching distance either result is correct.
          if ((c - o.centre).squaredNorm() <= touch * touch) exact.push_back(t.slot << 16 | o.slot);
        }
      }
      found.assign(set.pairs.begin(), set.pairs.end());
      std::sort(exact.begin(), exact.end());
      std::sort(found.begin(), found.end());
      std::vector<std::uint32_t> only;
      std::set_difference(exact.begin(), exact.end(), found.begin(), found.end(), std::back_inserter(only));
      missed += static_cast<int>(only.size());
      only.clear();
      std::set_difference(found.begin(), found.end(), exact.begin(), exact.end(), std::back_inserter(only));
      extra += static_cast<int>(only.size());
      // Poses that touch slightly: the cost of a first contact.
      if (!found.empty() && found.size() < 8)
        max_tests = std::max(max_tests, 100.0 * 8 * set.work / (double(tool.size()) * double(object.size())));
      if (n % 256 == 0) context.progress.check();
    }
  }
  out.add("pairs missed in " + std::to_string(3 * poses) + " poses", "1", missed, 0);
  out.add("pairs too many", "1", extra, 0);
  out.add("tests at a first contact, share of all pairs", "%", max_tests, 5);
  return out;
}

// The reference for F11: the same projection by Hildreth's method (dual coordinate ascent) in double, to convergence.
Eigen::Matrix<double, 6, 1> hildreth(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const Eigen::Matrix<double, 6, 1>& target) {
  Eigen::VectorXd lambda = Eigen::VectorXd::Zero(b.size());
  Eigen::Matrix<double, 6, 1> y = target;
  for (int round = 0; round < 200'000; ++round) {
    double change = 0;
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      const double step = std::max(-lambda[i], b[i] - a.row(i).dot(y));
      lambda[i] += step;
      y += step * a.row(i).transpose();
      change = std::max(change, std::abs(step));
    }
    if (change < 1e-12) break;
  }
  return y;
}

// Rows in a random cone of rank 3: in floats, as the runtime takes them, and in doubles for the reference.
struct DependentRows {
  std::array<std::vector<float>, 7> columns;  // 6 of `a`, then b
  Eigen::MatrixXd a;
  Eigen::VectorXd b;

  runtime::QpRows first(std::uint32_t count) const {
    runtime::QpRows rows;
    for (std::size_t k = 0; k < 6; ++k) rows.a[k] = columns[k].data();
    rows.b = columns[6].data();
    rows.count = count;
    return rows;
  }
};
DependentRows dependentRows(std::uint32_t count, Random& random) {
  DependentRows out;
  Eigen::Matrix<double, 3, 6> basis;
  for (int i = 0; i < 18; ++i) basis(i / 6, i % 6) = random.uniform(-1, 1);
  for (auto& column : out.columns) column.assign(count, 0);
  out.a.resize(count, 6);
  out.b.resize(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    Eigen::Matrix<double, 6, 1> row = basis.transpose() * Eigen::Vector3d(random.uniform(0, 1), random.uniform(0, 1), random.uniform(0, 1));
    row.normalize();
    for (std::size_t k = 0; k < 6; ++k) {
      out.columns[k][i] = static_cast<float>(row[static_cast<Eigen::Index>(k)]);
      out.a(i, static_cast<Eigen::Index>(k)) = out.columns[k][i];
    }
    out.columns[6][i] = static_cast<float>(random.uniform(-1, 1));
    out.b[i] = out.columns[6][i];
  }
  return out;
}

struct DependentQps {
  double apart = 0, order = 0;       // largest distance from the reference, and from the answer for rows in reverse order [mm]
  double time_us = 0;                // p99 of QPs with 200 rows, from a cold start
  std::uint32_t max_iterations = 0;  // of a QP
};
// QPs with 200 and 400 rows of rank 3, from a cold start. Neither the rank nor the order of the rows may change the
// result.
DependentQps solveDependentRows(const runtime::KernelTable& kernel, int repetitions, Random& random) {
  constexpr std::uint32_t kRows = 400;
  DependentQps out;
  TimeHistogram times;
  for (int n = 0; n < repetitions; ++n) {
    DependentRows rows = dependentRows(kRows, random);
    const auto solve = [&](std::uint32_t count) {
      const runtime::QpRows some = rows.first(count);
      runtime::QpAnswer answer;
      const double start = threadTime();
      runtime::solveQp6(kernel, some, runtime::Vector6::Zero(), answer);
      if (count == 200) times.add(threadTime() - start);
      out.max_iterations = std::max<std::uint32_t>(out.max_iterations, answer.iterations);
      return answer;
    };
    solve(200);
    if (n >= 20 && n % 10) continue;  // the reference is slow
    const runtime::QpAnswer answer = solve(kRows);
    // Rows of the reference have the length that rounding to float gave them.
    const Eigen::VectorXd scale = rows.a.rowwise().norm().cwiseInverse();
    const Eigen::MatrixXd unit = scale.asDiagonal() * rows.a;
    out.apart = std::max(out.apart, (answer.y - hildreth(unit, scale.cwiseProduct(rows.b), Eigen::Matrix<double, 6, 1>::Zero())).norm());
    for (auto& column : rows.columns) std::reverse(column.begin(), column.end());
    out.order = std::max(out.order, (solve(kRows).y - answer.y).norm());
  }
  out.time_us = times.quantile(0.99);
  return out;
}

// F11: linearly dependent rows.
Outcome redundantRows(ScenarioContext& context, Mode mode) {
  Outcome out;
  Random random(11);
  const Body &cube = context.bodies.get("cube"), &block = context.bodies.get("block");
  ScenarioRun flat(cube, {{&block, {}}}, mode);
  std::uint32_t iterations = 0;
  std::uint32_t max_rows = 0;
  const auto look = [&](const runtime::StepResult& r) {
    iterations = std::max(iterations, r.qp_iterations / std::max(1u, r.linearisations));
    max_rows = std::max(max_rows, r.rows);
  };
  flat.to({{0, 0, 13}, kUpright});
  flat.moveTo({0, 0, 9.5}, 100);
  for (int n = 0; n < context.repetitions(1'000'000, 500); ++n) {
    if (n % 256 == 0) context.progress.check();
    const Configuration pose{{1e-3 * random.uniform(-1, 1), 1e-3 * random.uniform(-1, 1), 9.5 + 1e-3 * random.uniform(-1, 1)}, kUpright};
    look(flat.to(pose));
  }
  const Body &cylinder = context.bodies.get("cylinder"), &groove = context.bodies.get("groove");
  ScenarioRun lying(cylinder, {{&groove, {}}}, mode);
  const Quaternion along_y = rotationOf({std::numbers::pi / 2, 0, 0});
  lying.to({{0, 0, 16}, along_y});
  lying.moveTo({0, 0, 8}, 100);
  for (int n = 0; n < context.repetitions(4'000, 200); ++n)
    look(lying.to({{1e-3 * random.uniform(-1, 1), 0, 8 + 1e-3 * random.uniform(-1, 1)}, along_y}));
  const DependentQps qps = solveDependentRows(*flat.workspace().memory().kernel, context.repetitions(2000, 200), random);
  out.add("QP iterations", "1", std::max(iterations, qps.max_iterations), 60);
  out.add("processor time of a QP of 200 rows, p99", "us", qps.time_us, 200);
  out.add("apart from an exact solver, 400 rows of rank 3", "mm", qps.apart, 1e-6);
  out.add("apart with the rows in reverse order", "mm", qps.order, 1e-6);
  out.note =
      "QPs of 200 and 400 rows from a cold start. Steps of the cube and of the cylinder had up to " + std::to_string(max_rows) + " rows.";
  flat.finish(out);
  return out;
}

// F15: metres or millimetres in the file; and the stiffness at the end of a lever.
Outcome units(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &ball = context.bodies.get("ball"), &groove = context.bodies.get("groove");
  TriangleMesh in_metres = groove.mesh;
  for (Eigen::Vector3d& p : in_metres.positions) p = 1000 * (p / 1000);  // as a file in metres is read
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;
  const std::string suffix = groove.name.substr(std::string("groove").size());  // the name of its variant
  const Body& from_metres = context.bodies.make("groove_m" + suffix, in_metres, settings, groove.frame);
  const Body& from_millimetres = context.bodies.make("groove_mm" + suffix, groove.mesh, settings, groove.frame);
  ScenarioRun a(ball, {{&from_millimetres, {}}}, mode), b(ball, {{&from_metres, {}}}, mode);
  double pose = 0, wrench = 0;
  for (int n = 0; n < 800; ++n) {
    const Configuration haptic{{2 * std::sin(n * 0.01), 3 * std::sin(n * 0.007), 16 - 0.01 * n}, kUpright};
    const runtime::StepResult ra = a.to(haptic), rb = b.to(haptic);
    pose = std::max(pose, (ra.graphic.position - rb.graphic.position).norm() / 16);
    wrench = std::max(wrench, (ra.wrench.force - rb.wrench.force).norm());
  }
  out.add("poses of a scene in metres and in mm, relative", "1", pose, 1e-9);
  out.add("their forces", "N", wrench, 1e-9);
  // A ball pushed by the side of the probe at distance L from the reference point feels the stiffness 1 / (1/k_t +
  // L^2/k_r).
  double worst = 0;
  const Body &probe = context.bodies.get("probe"), &small = context.bodies.get("small_ball");
  for (const double arm : {0.0, 20.0, 50.0, 80.0}) {
    ScenarioRun::Options options;
    options.reference_point = {0, 0, 10 + arm};
    ScenarioRun trial(probe, {{&small, {{0, 0, -arm}, kUpright}}}, mode, options);
    trial.to({{3, 0, 0}, kUpright});
    trial.moveTo({2, 0, 0}, 20);
    double touching = 0, first_force = 0, stiffness = 0;
    for (double x = 2.02; x > 1.2; x -= 0.002) {
      const runtime::StepResult r = trial.to({{x, 0, 0}, kUpright});
      const double force = r.wrench.force.x();
      if (force > 0.02 && touching == 0) touching = x, first_force = force;
      if (touching - x > 0.3 && touching > 0) {
        stiffness = (force - first_force) / (touching - x);
        break;
      }
    }
    worst = std::max(worst, 100 * std::abs(stiffness * (1 + arm * arm / 1000) - 1));
  }
  out.add("stiffness at the end of a lever, off the formula", "%", worst, 1);
  out.note = "A mesh in metres differs from one in millimetres in the last bit of its doubles; leaves are floats.";
  a.finish(out);
  return out;
}

// F18: torque at the gimbal.
Outcome gimbal(ScenarioContext& context, Mode mode) {
  Outcome out;
  const Body &probe = context.bodies.get("probe"), &slab = context.bodies.get("slab");
  double error = 0, omitted = 0;
  for (const double arm : {60.0, 100.0}) {
    ScenarioRun::Options options;
    options.reference_point = {0, 0, 40};
    ScenarioRun trial(probe, {{&slab, {}}}, mode, options);
    const Quaternion tilted = rotationOf({0, 0.6, 0});
    const auto at = [&](double height) {
      return Configuration{Eigen::Vector3d(0, 0, height) + tilted * Eigen::Vector3d(0, 0, 40), tilted};
    };
    for (double z = 4; z > -1.2; z -= 0.02) trial.to(at(z));
    for (int n = 0; n < 30; ++n) trial.to(at(-1.2));
    const RecordedStep& row = trial.last();
    const Eigen::Vector3d from = row.haptic.position, to = from + tilted * Eigen::Vector3d(0, 0, arm - 40);
    const Wrench moved = wrenchAbout(row.wrench, from, to);
    // The moment of the contact, from the point where the graphic tool's tip touches: the force acts along its line
    // there, for any reference point. Equilibrium of the graphic tool: the torque about its own reference point is
    // (contact - reference) x force.
    const Eigen::Vector3d tip = row.graphic.position + row.graphic.orientation * Eigen::Vector3d(0, 0, 1 - 40);
    const Eigen::Vector3d about_graphic = (tip - row.graphic.position).cross(row.wrench.force);
    const Eigen::Vector3d direct = about_graphic + (row.graphic.position - to).cross(row.wrench.force);
    const double newtons = std::max(0.1, row.wrench.force.norm());
    error = std::max(error, (moved.torque - direct).norm() / newtons);
    omitted = std::max(omitted, (row.wrench.torque - direct).norm() / newtons);
    if (arm == 100) trial.finish(out);
  }
  out.add("torque at the gimbal, off the contact's moment, for 1 N", "N mm", error, 0.1);
  out.add("the same without moving it from the reference point", "N mm", omitted, 0);
  out.figures.back().informative = true;
  return out;
}

}  // namespace

std::vector<Scenario> numericScenarios() {
  return {{"F6", "euler", "Euler singularity", euler, false},
          {"F7", "wrap", "Angle wrap in free space", wrap},
          {"F10", "pairs", "Missed leaf pairs", missedPairs, false, false},
          {"F11", "rows", "Redundant and dependent rows", redundantRows, false},
          {"F15", "units", "Units and levers", units, false},
          {"F18", "gimbal", "Reference point of the wrench", gimbal, false}};
}

}  // namespace spheretree::player
