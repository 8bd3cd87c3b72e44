// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/evaluate_tree.h"

#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "measure/cover_limits.h"
#include "measure/coverage.h"
#include "measure/evaluate_hulls.h"
#include "measure/evaluate_skin.h"
#include "measure/lower_bound.h"
#include "measure/overhang.h"
#include "measure/volumes.h"
#include "mesh/surface_with_sheets.h"
#include "spheretree/core/mesh_edit.h"

namespace spheretree::builder {

namespace {

constexpr double kTolerance = 1e-5;  // of the diagonal
constexpr double kVolumeLines = 512 * 512;

bool encloses(const Sphere& outer, const Sphere& inner, double tolerance) {
  const double dx = static_cast<double>(inner.x) - outer.x, dy = static_cast<double>(inner.y) - outer.y,
               dz = static_cast<double>(inner.z) - outer.z;
  return std::sqrt(dx * dx + dy * dy + dz * dz) + inner.radius <= outer.radius + tolerance;
}

HierarchyEvaluation evaluateHierarchy(const SphereTree& tree, double tolerance) {
  std::vector<std::uint32_t> parent(tree.nodeCount(), kNone);
  for (std::uint32_t node = 0; node < tree.nodeCount(); ++node)
    for (std::uint32_t k = 0; k < tree.child_count[node]; ++k) parent[tree.first_child[node] + k] = node;
  HierarchyEvaluation out;
  for (std::uint32_t leaf = 0; leaf < tree.nodeCount(); ++leaf) {
    if (!tree.isLeaf(leaf)) continue;
    ++out.leaves;
    bool outside_bound = false, outside_cover = false;
    for (std::uint32_t above = parent[leaf]; above != kNone; above = parent[above]) {
      outside_bound |= !encloses(tree.bound[tree.bound_index[above]], tree.cover[leaf], tolerance);
      outside_cover |= !encloses(tree.cover[above], tree.cover[leaf], tolerance);
    }
    out.leaves_outside_ancestor += outside_bound;
    out.leaves_outside_ancestor_cover += outside_cover;
  }
  return out;
}

std::size_t shareOf(double effort, auto whole) { return static_cast<std::size_t>(std::ceil(effort * static_cast<double>(whole))); }

/// The cover of a level of `tree`, measured on `mesh`; it has to cover `to_cover`.
LevelEvaluation evaluateLevel(const TriangleMesh& mesh, const DistanceField& field, const TriangleMesh& to_cover, const SphereTree& tree,
                              int level, const EvaluateSettings& settings, Progress& progress) {
  const auto share = [&](auto whole) { return shareOf(settings.effort, whole); };
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  std::vector<Ball> balls;
  for (const std::uint32_t node : levelSet(tree, level)) {
    const Sphere& sphere = tree.cover[node];
    balls.push_back({origin + centreOf(sphere), sphere.radius});
  }
  const SphereUnion set(balls);
  LevelEvaluation result;
  result.level = level;
  result.spheres = balls.size();
  OverhangSettings outside;
  outside.samples = share(outside.samples);
  outside.min_per_ball = share(outside.min_per_ball);
  outside.max_per_ball = share(outside.max_per_ball);
  outside.max_patches = share(outside.max_patches);
  result.overhang = measureOverhang(field, set, outside, progress);
  progress.advance(0.7);
  CoverageSettings gaps;
  gaps.tolerance = kTolerance * field.diagonal();
  gaps.samples = share(gaps.samples);
  gaps.seed = settings.seed;
  gaps.max_pieces = share(gaps.max_pieces);
  result.coverage = measureCoverage(to_cover, set, gaps, progress);
  progress.advance(0.9);
  const Volumes volumes = measureVolumes(mesh, set.balls(), share(kVolumeLines), progress);
  if (volumes.mesh > 0) {
    result.excess_volume_fraction = volumes.excess / volumes.mesh;
    result.missing_volume_fraction = volumes.missing / volumes.mesh;
  }
  progress.advance(1);
  return result;
}

Evaluation evaluate(const TriangleMesh& mesh, const SphereTree& tree, const EvaluateSettings& settings, Progress& progress,
                    const TriangleMesh& cover_too) {
  progress.stage("distance field");
  const SurfaceWithSheets surface = surfaceWithSheets(mesh, cover_too);
  const DistanceField& field = surface.field;
  Evaluation out;
  out.diagonal = field.diagonal();
  out.tolerance = kTolerance * field.diagonal();
  out.hierarchy = evaluateHierarchy(tree, out.tolerance);
  const TriangleMesh to_cover = joined(mesh, cover_too);
  const Eigen::Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  for (int level = 0; level < tree.levelCount(); ++level) {
    progress.stage("level " + std::to_string(level));
    out.levels.push_back(evaluateLevel(mesh, field, to_cover, tree, level, settings, progress));
  }
  if (!tree.skin.empty()) {
    progress.stage("skin");
    out.skin =
        settings.effort < 1 ? skinFigures(tree.skin) : evaluateSkin(tree.skin, origin, joined(mesh, surface.sheets), field, progress);
  }
  if (!tree.hulls.empty()) {
    progress.stage("hulls");
    HullSamples samples;
    samples.count = shareOf(settings.effort, samples.count), samples.seed = settings.seed;
    out.hulls = evaluateHulls(to_cover, field, tree.hulls, origin, samples, progress);
  }
  if (settings.limits) {
    progress.stage("limits");
    out.limits = coverLimits(mesh, field, out.levels.back().spheres, {.seed = settings.seed}, progress);
    progress.advance(1);
  }
  if (settings.lower_bound) {
    progress.stage("lower bound");
    const TriangleMesh whole = joined(mesh, surface.sheets);
    const LowerBound bound(whole, field, out.levels.back().spheres, settings.seed, progress);
    out.proven = provenLimit(bound, out.levels.back().spheres, out.levels.back().overhang.bound, progress);
    progress.advance(1);
  }
  return out;
}

}  // namespace

Evaluation evaluateTree(const TriangleMesh& mesh, const SphereTree& tree, const EvaluateSettings& settings, Progress& progress,
                        const TriangleMesh& cover_too) {
  if (tree.nodeCount() == 0 || tree.levelCount() < 1) throw std::invalid_argument("evaluate: the tree has no nodes");
  if (!(settings.effort > 0 && settings.effort <= 1)) throw std::invalid_argument("evaluate: effort must be above 0 and at most 1");
  const int cores = tbb::info::default_concurrency();
  tbb::task_arena arena(settings.threads > 0 ? std::min(settings.threads, cores) : cores);
  return arena.execute([&] { return evaluate(mesh, tree, settings, progress, cover_too); });
}

std::size_t leastSpheres(const TriangleMesh& mesh, double overhang, std::size_t spheres, std::uint64_t seed, Progress& progress,
                         const TriangleMesh& cover_too) {
  const SurfaceWithSheets surface = surfaceWithSheets(mesh, cover_too);
  const TriangleMesh whole = joined(mesh, surface.sheets);
  const double needed = LowerBound(whole, surface.field, spheres, seed, progress).spheresNeeded(overhang, progress);
  return static_cast<std::size_t>(std::max(1.0, std::ceil(needed)));
}

}  // namespace spheretree::builder
