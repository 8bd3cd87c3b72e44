// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of the builder: meshes that are difficult for it, and leaves against accuracy and time.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "scenarios/scenario_run.h"
#include "spheretree/builder/graded_tolerance.h"
#include "spheretree/builder/mesh_checks.h"

namespace spheretree::player {
namespace {

// A cube whose faces are grids: all vertices are cospherical or coplanar.
TriangleMesh gridCube() {
  TriangleMesh mesh = box({-5, -5, -5}, {5, 5, 5});
  for (int round = 0; round < 2; ++round) {
    TriangleMesh finer;
    std::map<std::array<long, 3>, std::uint32_t> index;
    const auto at = [&](const Eigen::Vector3d& p) {
      const auto [it, is_new] = index.try_emplace({std::lround(p.x() * 1e6), std::lround(p.y() * 1e6), std::lround(p.z() * 1e6)},
                                                  static_cast<std::uint32_t>(finer.positions.size()));
      if (is_new) finer.positions.push_back(p);
      return it->second;
    };
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const Eigen::Vector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
      const std::uint32_t ia = at(a), ib = at(b), ic = at(c), ab = at((a + b) / 2), bc = at((b + c) / 2), ca = at((c + a) / 2);
      finer.triangles.insert(finer.triangles.end(), {{ia, ab, ca}, {ab, ib, bc}, {ca, bc, ic}, {ab, bc, ca}});
    }
    mesh = std::move(finer);
  }
  return mesh;
}

// A box one of whose triangles is cut in three, with the new vertex 1e-9 from an edge.
TriangleMesh boxWithSliver() {
  TriangleMesh mesh = box({-5, -5, -5}, {5, 5, 5});
  const Triangle t = mesh.triangles[0];
  const auto middle = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.push_back((mesh.positions[t[0]] + mesh.positions[t[1]] + mesh.positions[t[2]]) / 3 * 1e-9 +
                           (mesh.positions[t[0]] + mesh.positions[t[1]]) / 2 * (1 - 1e-9));
  mesh.triangles[0] = {t[0], t[1], middle};
  mesh.triangles.push_back({t[1], t[2], middle});
  mesh.triangles.push_back({t[2], t[0], middle});
  return mesh;
}

struct DifficultMesh {
  TriangleMesh mesh;
  bool is_good;  // closed, and each triangle wound outward
};
std::vector<DifficultMesh> difficultMeshes() {
  const TriangleMesh grid = gridCube();
  std::vector<Eigen::Vector2d> half_circle;
  for (int i = 0; i <= 16; ++i)
    half_circle.emplace_back(i % 16 ? 5 * std::sin(i * std::numbers::pi / 16) : 0, -5 * std::cos(i * std::numbers::pi / 16));
  TriangleMesh doubled = grid, flipped = grid, open = grid;
  doubled.triangles.push_back(doubled.triangles[3]);
  std::swap(flipped.triangles[5][0], flipped.triangles[5][1]);
  open.triangles.pop_back();
  return {{grid, true},
          {lathe(half_circle, 32), true},
          {lathe({{0, -5}, {5, -5}, {5, 5}, {0, 5}}, 24), true},
          {boxWithSliver(), true},
          {doubled, false},
          {flipped, false},
          {open, false}};
}

std::size_t uncoveredPoints(const SphereTree& tree, std::span<const std::uint32_t> leaves, const std::vector<Eigen::Vector3d>& points) {
  std::size_t uncovered = 0;
  for (const Eigen::Vector3d& p : points) {
    bool covered = false;
    for (const std::uint32_t leaf : leaves) {
      const Sphere& s = tree.cover[leaf];
      covered = covered || (centreOf(s) - p).norm() <= double(s.radius) + 1e-9;
    }
    uncovered += !covered;
  }
  return uncovered;
}

// How far leaves reach beyond the stated overhang, along 64 rays from each centre [mm].
double reachBeyondBound(const SphereTree& tree, std::span<const std::uint32_t> leaves, const builder::DistanceField& field) {
  double beyond = 0;
  for (const std::uint32_t leaf : leaves) {
    const Sphere& s = tree.cover[leaf];
    for (int k = 0; k < 64; ++k) {
      const double z = 1 - (2 * k + 1.0) / 64, r = std::sqrt(1 - z * z), turn = 2.399963229728653 * k;
      const Eigen::Vector3d p = centreOf(s) + double(s.radius) * Eigen::Vector3d(r * std::cos(turn), r * std::sin(turn), z);
      beyond = std::max(beyond, field.signedDistance(p) - double(tree.statistics.back().overhang_bound));
    }
  }
  return beyond;
}

// F12: meshes with degenerate medial axes. It tests the builder and is the same in both modes.
Outcome degenerate(ScenarioContext& context, Mode) {
  Outcome out;
  int unexplained = 0, different = 0;
  std::size_t uncovered = 0;
  double beyond = 0;
  for (const auto& [mesh, is_good] : difficultMeshes()) {
    const builder::MeshReport report = builder::checkMesh(mesh);
    if (!is_good || !report.clean()) {
      unexplained += is_good || report.summary().empty();
      continue;
    }
    builder::BuildSettings settings;
    settings.levels = 3;
    settings.quality = builder::Quality::Quick;
    const builder::BuildResult result = builder::buildSphereTree(mesh, settings, context.progress);
    different += !(builder::buildSphereTree(mesh, settings, context.progress).tree == result.tree);
    unexplained += !findFault(result.tree).empty();
    const builder::DistanceField field(mesh);
    const auto leaves = levelSet(result.tree, result.tree.levelCount() - 1);
    uncovered += uncoveredPoints(result.tree, leaves, surfacePoints(mesh, field.diagonal() / 60));
    beyond = std::max(beyond, reachBeyondBound(result.tree, leaves, field));
  }
  out.add("meshes without a sound tree or a reason", "1", unexplained, 0);
  out.add("surface points that no leaf covers", "1", double(uncovered), 0);
  out.add("reach of a leaf beyond the stated bound", "mm", std::max(0.0, beyond), 1e-6);
  out.add("trees that differ when built again", "1", different, 0);
  out.note = "Of the builder: the same in both modes.";
  return out;
}

struct Need {
  std::string name;
  double tolerance;  // [mm]
};

// The objects of the published scene: a probe, 28 teeth, two jaws; and a single molar. `part`: share of the teeth.
std::vector<Need> publishedObjects(double part) {
  std::vector<Need> out{{"dental_probe", 0.1}, {"molar", 0.1}, {"lower_jaw", 0.1}, {"upper_jaw", 0.1}};
  for (int tooth = 0; tooth < 28; tooth += part < 0.5 ? 4 : 1)
    out.push_back({"tooth_" + std::to_string(1 + tooth / 7) + std::to_string(1 + tooth % 7), 0.1});
  return out;
}

// F22: the number of leaves that a tolerance needs, of the 512 that were published for each object; leaves against
// accuracy and time.
Outcome noMoreThanNeeded(ScenarioContext& context, Mode mode) {
  Outcome out;
  builder::BuildSettings settings;
  settings.quality = context.bodies.quality();
  double leaves = 0, all = 0, over = 0, max_of_teeth = 0;
  for (const auto& [name, tolerance] : publishedObjects(context.settings.share)) {
    const TriangleMesh mesh = BodyLibrary::mesh(name);
    settings.tolerance_mm = tolerance;
    settings.tolerance_of_triangle_mm.clear();
    if (name == "dental_probe") {  // its tip is at the origin
      builder::ToleranceRegion tip;
      tip.radius = 5;
      tip.tolerance = settings.tolerance_mm = 0.05;
      settings.tolerance_of_triangle_mm = builder::gradedTolerance(mesh, tolerance, {&tip, 1}, {}, 0);
    }
    const SphereTree& tree = context.bodies.tree(mesh, settings);
    const LevelStatistics& last = tree.statistics.back();
    const float reached = tree.provenance.work_overhang_mm > 0 ? tree.provenance.work_overhang_mm : last.overhang_bound;
    over += static_cast<double>(reached) > settings.tolerance_mm || last.sphere_count >= 512;
    leaves += last.sphere_count;
    ++all;
    if (name.starts_with("tooth"))
      max_of_teeth = std::max(max_of_teeth, static_cast<double>(last.sphere_count));
    else
      out.note += name + ": " + std::to_string(last.sphere_count) + " leaves within " + text(static_cast<double>(reached)) + " mm. ";
  }
  out.note += "The largest of the teeth: " + text(max_of_teeth) + " leaves.";
  out.add("objects that need 512 leaves or more for their tolerance", "%", 100 * over / all, 50);
  out.add("leaves of all of them, share of 512 for each", "%", 100 * leaves / (512 * all), 100);
  settings.quality = builder::Quality::Quick;
  settings.tolerance_of_triangle_mm.clear();
  settings.tolerance_mm = 0;
  const auto body = [&](const char* name, int levels) -> const Body& {
    settings.levels = levels;
    return context.bodies.make(std::string(name).append("_quick_").append(std::to_string(levels)), context.bodies.get(name).mesh, settings);
  };
  const Body& tool = body("dental_probe", 4);
  for (int levels = 2; levels <= (context.settings.share < 0.5 ? 4 : 5); ++levels) {
    const Body& object = body("molar", levels);
    ScenarioRun trial(tool, {{&object, {}}}, mode);
    std::vector<double> pairs;
    trial.to({{0, 0, 14}, kUpright});
    for (int n = 0; n < 1500; ++n)
      pairs.push_back(trial
                          .to({{4 * std::sin(n * 0.004), 3 * std::sin(n * 0.007), 6 + 4 * std::cos(n * 0.003)},
                               rotationOf({0.3 * std::sin(n * 0.002), 0, 0})})
                          .pairs);
    std::nth_element(pairs.begin(), pairs.begin() + 750, pairs.end());
    const std::string of = " on a molar of " + std::to_string(static_cast<int>(std::pow(8, levels - 1))) + " leaves";
    for (const auto& [quantity, unit, value] :
         {std::tuple{"overhang", "mm", leafOverhang(object)}, std::tuple{"pairs, median,", "1", pairs[750]},
          std::tuple{"processor time of a step, median,", "us", trial.times().quantile(0.5)},
          std::tuple{"processor time of a step, p99,", "us", trial.times().quantile(0.99)}}) {
      out.add(quantity + of, unit, value, 0);
      out.figures.back().informative = true;
    }
    if (levels == 4) trial.finish(out);
  }
  return out;
}

}  // namespace

std::vector<Scenario> builderScenarios() {
  return {{"F12", "degenerate", "Degenerate medial axes (builder)", degenerate, false, false},
          {"F22", "leaves", "No more leaves than needed", noMoreThanNeeded, false, false}};
}

}  // namespace spheretree::player
