// SPDX-License-Identifier: GPL-3.0-or-later
#include "comparison/cutting.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>
#include <stdexcept>

#include "cavity.h"
#include "measure/evaluate_skin.h"
#include "page/chart.h"
#include "page/page.h"
#include "published/voxel_renderer.h"
#include "quantile.h"
#include "run/real_time.h"
#include "run/run_statistics.h"
#include "scene/compiled_scene.h"
#include "state/step_memory.h"
#include "text_table.h"

namespace spheretree::player {
namespace {

using Eigen::Vector3d;
using tool::shortNumber;

constexpr std::array kFeeds{0.5, 2.0};  // of the hand; a ball of 1 mm removes voxels of 0.1 mm as fast as the first one [mm/s]
constexpr double kStart = 0.1;          // way of the burr to the block [mm]
constexpr double kDeep = 1.5;           // of the way in the block [mm]
constexpr double kHeld = 15;            // the reference point: so far above the burr the hand holds the handpiece [mm]
constexpr double kTolerance = 0.05;     // of the leaves of the handpiece [mm]

/// The hand at a constant feed, while the burr of a tool that is held upright and does not turn would go from `from` to
/// `to`; then everything is turned.
formats::Trajectory feed(const Vector3d& from, const Vector3d& to, double speed, const Quaternion& turn) {
  formats::Trajectory out;
  const int steps = static_cast<int>(std::ceil(1000 * (to - from).norm() / speed));
  for (int n = 0; n <= steps; ++n) out.poses.push_back({turn * (from + (to - from) * (double(n) / steps) + Vector3d(0, 0, kHeld)), turn});
  return out;
}

bool spinsIn(const formats::Trajectory& hand, std::size_t n) { return hand.spins.empty() || hand.spins[n]; }

using Step = std::function<runtime::StepResult(const Configuration&, bool)>;

/// What one renderer does on a course, but for what it removed.
CuttingRow follow(const CuttingCourse& course, const std::string& renderer, std::span<const CutSolid> solids, const Step& step,
                  builder::Progress& progress) {
  CuttingRow row{.course = course.name, .renderer = renderer};
  TimeHistogram times;
  std::vector<double> changes;
  std::vector<Configuration> tool;
  Vector3d force = Vector3d::Zero();
  for (std::size_t n = 0; n < course.hand.poses.size(); ++n) {
    if (n % 1000 == 0) progress.check();
    const Configuration& hand = course.hand.poses[n];
    const double begun = threadTime();
    const runtime::StepResult result = step(hand, spinsIn(course.hand, n));
    times.add(threadTime() - begun);
    const double own = n == 0 ? 0 : course.scene.coupling.translation * (hand.position - course.hand.poses[n - 1].position).norm();
    changes.push_back((result.wrench.force - force).norm());
    row.beyond = std::max(row.beyond, changes.back() - own);
    force = result.wrench.force;
    tool.push_back(result.graphic);
    row.force.push_back(static_cast<float>(force.norm()));
    row.largest_force = std::max(row.largest_force, force.norm());
    row.largest_torque = std::max(row.largest_torque, result.wrench.torque.norm());
  }
  row.change_largest = *std::max_element(changes.begin(), changes.end());
  row.change_p99 = tool::quantile(changes, 0.99);
  row.time_median = times.quantile(0.5), row.time_p99 = times.quantile(0.99);
  for (const CutSolid& solid : solids) {
    const Configuration to_object = inverse(course.scene.objects[solid.object].pose);
    std::vector<builder::BurrPath> paths;
    for (const Ball& ball : course.scene.burr)
      for (std::size_t n = 1; n < tool.size(); ++n) {
        if (!spinsIn(course.hand, n)) continue;
        const auto centre = [&](const Configuration& pose) {
          const Configuration in_object = composed(to_object, pose);
          return Vector3d(in_object.position + in_object.orientation * (ball.centre - course.scene.reference_point));
        };
        if (n == 1 || !spinsIn(course.hand, n - 1)) paths.push_back({ball.radius, {centre(tool[n - 1])}});
        paths.back().centres.push_back(centre(tool[n]));
      }
    if (paths.empty()) continue;
    const builder::VolumeBounds swept = builder::removedVolumes({solid.field, 1}, paths, {}, progress).total;
    row.swept.low += swept.low, row.swept.high += swept.high;
  }
  return row;
}

const std::vector<std::string> kHeads{
    "course",        "renderer",    "force [N]",     "change in a step [mN]", "p99 [mN]",       "beyond the hand [mN]",
    "removed [mm3]", "swept [mm3]", "torque [N mm]", "step, median [us]",     "step, p99 [us]", "memory [MB]"};

std::vector<std::string> cellsOf(const CuttingRow& r) {
  return {r.course,
          r.renderer,
          shortNumber(r.largest_force),
          shortNumber(1000 * r.change_largest),
          shortNumber(1000 * r.change_p99),
          shortNumber(1000 * r.beyond),
          shortNumber(r.removed),
          shortNumber((r.swept.low + r.swept.high) / 2),
          r.largest_torque < 1e-6 ? "0" : shortNumber(r.largest_torque),
          shortNumber(r.time_median),
          shortNumber(r.time_p99),
          shortNumber(static_cast<double>(r.bytes) / 1e6)};
}

}  // namespace

std::vector<CuttingCourse> cuttingBench(BodyLibrary& bodies, const Vector3d& half, const Quaternion& turn) {
  TriangleMesh block = box(-half, half);
  for (Vector3d& p : block.positions) p = turn * p;
  builder::BuildSettings settings;
  settings.quality = builder::Quality::Quick;
  settings.levels = 3;
  runtime::SceneDescription scene;
  scene.objects.push_back({bodies.tree(block, settings), {}});
  std::string fault;
  scene.objects[0].cut = runtime::cutModel(scene.objects[0].tree, {1, {}, 0.5}, fault);
  if (!scene.objects[0].cut) throw std::runtime_error(fault);
  settings.tolerance_mm = kTolerance;
  settings.levels = builder::BuildSettings{}.levels;
  scene.tool = bodies.tree(samples::makeHandpiece(), settings);
  scene.burr = {samples::kBurr};
  scene.reference_point = {0, 0, kHeld};
  const double r = samples::kBurr.radius, top = half.z(), side = half.x() + r;
  std::vector<CuttingCourse> courses;
  for (const double speed : kFeeds) {
    const std::string at = " at " + shortNumber(speed) + " mm/s";
    courses.push_back({"plunge" + at, scene, feed({0, 0, top + r + kStart}, {0, 0, top + r - kDeep}, speed, turn)});
    courses.push_back({"side cut" + at, scene, feed({side + kStart, 0, top}, {side - kDeep, 0, top}, speed, turn)});
  }
  return courses;
}

std::vector<CuttingRow> compareCutting(const CuttingCourse& course, double edge, builder::Progress& progress) {
  runtime::Scene scene;
  std::string fault;
  if (!runtime::compileScene(course.scene, scene, fault)) throw std::invalid_argument(fault);
  runtime::Workspace workspace(scene);
  if (!runtime::setSpindle(true, workspace)) throw std::invalid_argument("the scene has no burr, or no object that can be cut");
  std::vector<builder::DistanceField> fields;
  std::vector<CutSolid> solids;
  double voxels = 0;
  for (std::size_t i = 0; i < course.scene.objects.size(); ++i) {
    const SphereTree& tree = *course.scene.objects[i].tree;
    if (!course.scene.objects[i].cut) continue;
    fields.emplace_back(builder::flatTriangles(tree.skin, {tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]}));
    solids.push_back({i, nullptr});
    voxels += VoxelRenderer::voxelCount(fields.back(), edge);
  }
  for (std::size_t k = 0; k < solids.size(); ++k) solids[k].field = &fields[k];
  if (voxels > VoxelRenderer::kMostVoxels) throw std::invalid_argument("the objects have too many voxels of this size; use larger ones");

  std::vector<CuttingRow> rows;
  const auto ours = [&](const Configuration& hand, bool spins) {
    runtime::setSpindle(spins, workspace);
    return runtime::step(scene, hand, runtime::Mode::Constrained, workspace);
  };
  rows.push_back(follow(course, "constrained", solids, ours, progress));
  for (const CutSolid& solid : solids) {
    const auto removed = runtime::cutState(solid.object, workspace).removed;
    rows[0].removed += std::accumulate(removed.begin(), removed.end(), 0.0);
  }
  rows[0].bytes = scene.byteCount() + workspace.memory().cutting->byteCount();

  VoxelRenderer drill(course.scene, scene, solids, edge);
  const auto theirs = [&](const Configuration& hand, bool spins) {
    drill.setSpindle(spins);
    return drill.step(hand);
  };
  rows.push_back(follow(course, "voxels", solids, theirs, progress));
  rows[1].removed = static_cast<double>(drill.removed()) * edge * edge * edge;
  rows[1].bytes = drill.byteCount();
  return rows;
}

std::string cuttingTable(std::span<const CuttingRow> rows) {
  std::vector<std::vector<std::string>> lines{kHeads};
  for (const CuttingRow& row : rows) lines.push_back(cellsOf(row));
  return tool::textTable(lines);
}

nlohmann::ordered_json cuttingJson(std::span<const CuttingRow> rows, double edge) {
  nlohmann::ordered_json out{{"schema", "spheretree.cutting/1"}, {"voxel_mm", edge}, {"rows", nlohmann::ordered_json::array()}};
  for (const CuttingRow& r : rows)
    out["rows"].push_back({{"course", r.course},
                           {"renderer", r.renderer},
                           {"largest_force_n", r.largest_force},
                           {"force_change_n", {{"largest", r.change_largest}, {"p99", r.change_p99}, {"beyond_hand", r.beyond}}},
                           {"removed_mm3", r.removed},
                           {"swept_mm3", {{"low", r.swept.low}, {"high", r.swept.high}}},
                           {"largest_torque_nmm", r.largest_torque},
                           {"time_us", {{"median", r.time_median}, {"p99", r.time_p99}}},
                           {"memory_bytes", r.bytes},
                           {"force_n", r.force}});
  return out;
}

std::string cuttingSection(std::span<const CuttingRow> rows) {
  std::string charts;
  tool::HtmlTable table{
      "Force, its change in a step and torque: the largest. Beyond the hand: less the motion of the hand in that step times the "
      "stiffness of the coupling. Removed: as the "
      "renderer counts it. Swept: by the burr on the way that it was shown, the middle of proven bounds.",
      kHeads,
      {}};
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::vector<std::string> cells = cellsOf(rows[i]);
    for (std::string& cell : cells) cell = tool::escaped(cell);
    table.rows.push_back(cells);
    if (i + 1 == rows.size() || rows[i].course != rows[i + 1].course) continue;
    tool::TraceChart chart{rows[i].course + ": force on the hand", "time [s]", "force [N]", {}, {}, false, {}};
    for (std::size_t n = 0; n < rows[i].force.size(); ++n) chart.x.push_back(0.001f * static_cast<float>(n));
    for (const CuttingRow& row : rows.subspan(i, 2)) chart.traces.push_back({row.renderer, row.force});
    charts += tool::traceCharts(chart);
  }
  return "<div class=\"charts wide\">" + charts + "</div>" + table.html();
}

}  // namespace spheretree::player
