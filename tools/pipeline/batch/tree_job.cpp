// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/tree_job.h"

#include <algorithm>
#include <charconv>
#include <chrono>

#include "generator.h"
#include "measure/evaluate_skin.h"
#include "pipeline/builder_names.h"
#include "pipeline/sound_mesh.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/provenance.h"

namespace spheretree::pipeline {
namespace {

using tool::kGenerator;

// Share of the samples of `evaluate`: with a twentieth, measuring every level costs less than the build.
constexpr double kMeasuringEffort = 0.05;

Hash128 hashOf(std::string_view text) { return builder::bytesHash(std::as_bytes(std::span(text))); }

std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

// Everything on which the tolerances of triangles depend besides the mesh. A region that is too far away to change one
// is not part of it, so that an edited region rebuilds only what it concerns.
std::string workText(const WorkRegions& work, const std::vector<formats::WorkRegion>& regions, const Configuration& pose) {
  if (regions.empty() && !work.reach) return "";
  formats::SceneFile only;
  only.work = regions;
  only.tool.name = "tool";
  std::string text = formats::sceneText(only) + work.reach_key;
  for (const double x : {pose.position.x(), pose.position.y(), pose.position.z(), pose.orientation.w(), pose.orientation.x(),
                         pose.orientation.y(), pose.orientation.z()})
    text += "\n" + std::to_string(x);
  return text;
}

double diagonalOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.positions) box.extend(p);
  return box.diagonal().norm();
}

// If all places have the same tolerance, uses the plain search for it.
void setTolerances(builder::BuildSettings& settings, std::vector<double> tolerances) {
  const auto [smallest, largest] = std::minmax_element(tolerances.begin(), tolerances.end());
  settings.tolerance_mm = *smallest;
  if (*smallest < *largest) settings.tolerance_of_triangle_mm = std::move(tolerances);
}

// The tolerances then only determine where an overhang matters less, and by how much.
void useAllLeaves(builder::BuildSettings& settings) {
  constexpr double kUnreached = 1e-6;  // relative to the smallest tolerance: no leaves are left out for it
  if (settings.skin_tolerance_mm == 0) settings.skin_tolerance_mm = settings.tolerance_mm;  // the skin uses the original tolerance
  const double less = (1 - kUnreached) * settings.tolerance_mm;
  for (double& t : settings.tolerance_of_triangle_mm) t -= less;
  settings.tolerance_mm = settings.tolerance_of_triangle_mm.empty() ? 0 : settings.tolerance_mm - less;
}

std::vector<LevelFigures> levelsOf(const builder::RepairedMesh& repaired, const SphereTree& tree, builder::Progress& progress) {
  builder::EvaluateSettings settings;
  settings.limits = false;
  settings.effort = kMeasuringEffort;
  builder::Evaluation evaluation = builder::evaluateTree(repaired.mesh, tree, settings, progress, repaired.to_cover);
  std::vector<LevelFigures> levels;
  for (builder::LevelEvaluation& level : evaluation.levels) {
    // The bound of the builder is often tighter, since this measurement has little effort.
    const double proven = tree.statistics[static_cast<std::size_t>(level.level)].overhang_bound;
    if (proven >= 0) level.overhang.bound = std::min(proven, level.overhang.bound);
    levels.push_back({level.level, level.spheres, level.overhang.bound, level});
  }
  return levels;
}

TreeFigures figuresOf(const builder::BuildResult& built, const builder::RepairedMesh& repaired, double tolerance_mm) {
  TreeFigures figures;
  figures.triangles = repaired.mesh.triangles.size();
  figures.leaves = built.statistics.levels.back().spheres;
  figures.nodes = built.tree.nodeCount();
  figures.diagonal_mm = built.tree.provenance.diagonal_mm;
  figures.certified = true;
  figures.input_triangles = repaired.report.triangles;
  for (const builder::RepairStep& step : repaired.steps)
    figures.repair.push_back({std::string(builder::name(step.kind)), step.text, step.count, step.removed.size(), step.change_mm});
  if (!built.tree.skin.empty()) figures.skin = builder::skinFigures(built.tree.skin);
  if (tolerance_mm > 0) {
    figures.tolerance_mm = tolerance_mm;
    figures.tolerance_met = built.statistics.tolerance_met;
  }
  return figures;
}

}  // namespace

builder::BuildSettings buildSettings(const formats::TreeSettings& settings) {
  builder::BuildSettings out;
  if (settings.builder) out.builder = byName(kBuilders, *settings.builder);
  if (settings.search) out.search = *settings.search && out.builder != BuilderKind::Cover;  // a default beside objects with cover
  if (settings.medial_axis) out.medial_axis = byName(kMedialAxes, *settings.medial_axis);
  if (settings.quality) out.quality = byName(kQualities, *settings.quality);
  if (settings.levels) out.levels = *settings.levels;
  if (settings.branching) out.branching = *settings.branching;
  if (settings.tolerance_mm) out.tolerance_mm = *settings.tolerance_mm;
  if (settings.seed) out.seed = *settings.seed;
  if (settings.skin_mm) {
    out.skin = *settings.skin_mm > 0;
    out.skin_tolerance_mm = *settings.skin_mm;
  }
  if (settings.crease_angle_deg) out.crease_angle_deg = *settings.crease_angle_deg;
  return out;
}

std::string TreeJob::meshKey() const {
  return toHex(hashOf(kGenerator + "\n" + toHex(file->hash) + "\n" + part + '\0' + std::to_string(file->mesh.unit_mm) + "\n" + repair));
}

void TreeJob::grade(std::shared_ptr<const WorkRegions> regions) {
  work = std::move(regions);
  world_box.setEmpty();
  if (work->regions.empty()) return;
  for (const Eigen::Vector3d& p : inWorld(part.empty() ? file->mesh.mesh : partOf(file->mesh.mesh, part, file->components), pose).positions)
    world_box.extend(p);
}

std::vector<formats::WorkRegion> TreeJob::regions() const {
  return work ? regionsInRange(*work, world_box, settings.tolerance_mm, scale) : std::vector<formats::WorkRegion>();
}

std::string TreeJob::key() const {
  return toHex(hashOf(meshKey() + "\n" + kRecordSchema + "\n" + builder::settingsText(settings) +
                      (work ? workText(*work, regions(), pose) : "") + (scale == 1 ? "" : "\nscale=" + shortest(scale)) +
                      (is_for_error ? "\nfor error" : "")));
}

builder::RepairedMesh TreeJob::solid(builder::Progress& progress) const {
  const TriangleMesh input = part.empty() ? file->mesh.mesh : partOf(file->mesh.mesh, part, file->components);
  progress.check();
  std::vector<std::string> ignored;  // the repaired mesh has them, too
  return soundMesh(input, path.string() + (part.empty() ? "" : " part " + part), repairKind(repair), ignored, progress);
}

TreeResult TreeJob::run(builder::Progress& progress) const {
  const auto begun = std::chrono::steady_clock::now();
  const builder::RepairedMesh repaired = solid(progress);
  const TriangleMesh& mesh = repaired.mesh;
  progress.check();
  builder::BuildSettings own = settings;
  own.unit_mm = file->mesh.unit_mm;
  const std::vector<formats::WorkRegion> near = regions();
  const bool is_graded = work && (!near.empty() || work->reach) && settings.tolerance_mm > 0 && settings.searches();
  const double wanted = settings.tolerance_mm > 0 ? settings.tolerance_mm : 1;
  if (is_graded)
    setTolerances(own, tolerancesAt(*work, near, inWorld(mesh, pose), settings.tolerance_mm, scale));
  else if (is_for_error)
    own.tolerance_mm = scale * wanted;
  if (is_for_error && own.skin_tolerance_mm == 0)
    own.skin_tolerance_mm = settings.tolerance_mm > 0 ? own.tolerance_mm / scale : builder::kSkinTolerance * diagonalOf(mesh);
  const double min_tolerance = own.tolerance_mm;
  if (own.max_leaves > 0) useAllLeaves(own);
  builder::BuildResult built = builder::buildSphereTree(mesh, own, progress, repaired.to_cover);

  TreeFigures figures = figuresOf(built, repaired, settings.tolerance_mm);
  figures.notes = file->mesh.notes;
  figures.notes.insert(figures.notes.end(), built.statistics.notes.begin(), built.statistics.notes.end());
  figures.levels = levelsOf(repaired, built.tree, progress);
  if (is_graded) figures.min_tolerance_mm = min_tolerance;
  if (own.max_leaves > 0 || is_for_error) {
    const double met = built.statistics.min_tolerance_mm;
    // Graded: every tolerance is met if all are multiplied by this ratio.
    const double ratio = is_graded ? scale * std::max(1.0, met / min_tolerance) : met / wanted;
    if (settings.tolerance_mm > 0) figures.tolerance_met = ratio <= 1;
    figures.ratio = ToleranceRatio{ratio, is_graded ? std::optional<double>(met) : std::nullopt};
  }
  if (!near.empty()) figures.work = workFigures(near, mesh, pose, built.tree);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return {std::move(built.tree), std::move(figures), seconds};
}

}  // namespace spheretree::pipeline
