// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/batch.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>

#include "base/useful_threads.h"
#include "generator.h"
#include "json_text.h"
#include "pipeline/batch/budget_search.h"
#include "pipeline/batch/reference_point.h"
#include "pipeline/batch/soften_items.h"
#include "pipeline/batch/speed_rows.h"
#include "program_end.h"
#include "run_files.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::pipeline {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kReadShare = 0.02,
                 kWriteShare = 0.02;  // shares of the progress of a whole batch, approximately those of a batch of 30 teeth

void check(const BatchSettings& settings) {
  using tool::UsageError;
  if (settings.shard.count > 1 && settings.budget)
    throw UsageError("--budget shares leaves among all objects, so it cannot be sharded. Leave --shard out.");
  if (settings.shard.count > 1 && settings.speed)
    throw UsageError("--chart belongs to the run that writes the results. Leave out --shard or --chart.");
  if (!settings.paths.empty() && !settings.speed && !(settings.budget && settings.budget->is_time))
    throw UsageError("--trajectory is for --chart and for a --budget in us. Leave it out, or add one of them.");
  if (settings.dry_run && (settings.budget || settings.speed || settings.shard.count > 1))
    throw UsageError("--dry-run cannot tell what --budget, --chart or --shard would build. Leave them out.");
}

/// The options of a quick look have precedence over the scene.
void override(const formats::TreeSettings& overrides, formats::TreeSettings& own) { own = formats::mergedSettings(overrides, own); }

/// The scene of the batch: read, or drafted from mesh files.
struct Task {
  std::filesystem::path path;  // of the scene: its paths are relative to it
  formats::SceneFile scene;
  SceneDraft draft;
};

Task taskOf(const BatchSettings& settings, MeshStore& meshes) {
  Task task;
  if (settings.draft) {
    task.path = settings.folder / kDraftedScene;
    task.draft = draftScene(*settings.draft, task.path, meshes);
    task.scene = task.draft.scene;
  } else {
    task.path = settings.scene;
    task.scene = formats::readScene(settings.scene);
  }
  override(settings.overrides, task.scene.tool.settings);
  for (formats::SceneItem& object : task.scene.objects) override(settings.overrides, object.settings);
  return task;
}

/// `path` of the scene file `scene`, as the scene in `folder` names it.
std::filesystem::path rebased(const std::filesystem::path& path, const std::filesystem::path& scene, const std::filesystem::path& folder) {
  return path.empty() || path.is_absolute() ? path : std::filesystem::proximate(formats::scenePath(scene, path), folder);
}

/// The scene that the player loads: trees, and the meshes from which they were built for display, without the failed
/// objects.
formats::SceneFile compiledScene(const Task& task, const BatchSettings& settings, const std::vector<BatchItem>& items) {
  formats::SceneFile out = task.scene;
  out.defaults = {};
  out.objects.clear();
  for (formats::SceneBody& body : out.bodies) body.pose_csv = rebased(body.pose_csv, task.path, settings.folder);
  for (const BatchItem& item : items) {
    if (item.status == ItemStatus::Failed || item.layer) continue;
    formats::SceneItem compiled = *item.source;
    compiled.mesh = rebased(compiled.mesh, task.path, settings.folder);
    if (compiled.cut)
      for (formats::CutLayer& layer : compiled.cut->layers) {
        layer.mesh = rebased(layer.mesh, task.path, settings.folder);
        if (&layer != compiled.cut->layers.data()) layer.tree = layerName(compiled, layer) + ".stree";
      }
    compiled.settings = {};
    compiled.soft.reset();
    compiled.tree = item.treeName();
    if (item.is_tool)
      out.tool = std::move(compiled);
    else
      out.objects.push_back(std::move(compiled));
  }
  return out;
}

/// Leaves that levels and branching allow, but that the tolerance did not need.
std::size_t savedLeaves(const BatchItem& item) {
  const builder::BuildSettings& settings = item.job.settings;
  if (item.key.empty() || settings.max_leaves > 0 || item.job.is_for_error || !(settings.tolerance_mm > 0)) return 0;
  std::size_t allowed = 1;
  for (int level = 1; level < settings.levels; ++level) allowed *= static_cast<std::size_t>(settings.branching);
  return allowed - std::min(allowed, item.result.figures.leaves);
}

ObjectResult resultOf(BatchItem& item) {
  ObjectResult out;
  out.name = item.source->name;
  out.is_tool = item.is_tool;
  out.status = item.status;
  out.error = item.error;
  if (!item.hasTree()) return out;
  out.saved = savedLeaves(item);
  out.seconds = item.result.seconds;
  out.tree = item.treeName();
  out.figures = std::move(item.result.figures);
  return out;
}

void writeResults(const BatchSettings& settings, const Task& task, const std::vector<BatchItem>& items, tool::WorkProgress& progress,
                  BatchResult& result) {
  progress.stage("write");
  if (settings.draft) formats::writeWhole(task.path, formats::sceneText(task.draft.scene));
  if (!task.draft.ball.empty()) formats::writeWhole(task.draft.ball, task.draft.ball_mesh);
  formats::WholeFiles trees;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (!items[i].hasTree()) continue;
    const std::vector<std::byte> bytes = items[i].soft.empty() ? encodeSphereTree(items[i].result.tree) : items[i].soft;
    result.objects[i].bytes = bytes.size();
    trees.add(settings.folder / result.objects[i].tree, bytes);
    progress.advance(static_cast<double>(i + 1) / static_cast<double>(items.size()));
  }
  trees.commit();
  const formats::SceneFile compiled = compiledScene(task, settings, items);
  // Without a tool or any object there is no scene to load, and an older file would be mistaken for it.
  if (!items[0].hasTree() || compiled.objects.empty())
    std::filesystem::remove(settings.folder / "scene.json");
  else
    formats::writeWhole(settings.folder / "scene.json", formats::sceneText(compiled));
  formats::writeWhole(settings.folder / "report.json", tool::jsonText(toJson(result), 1) + "\n");
}

/// An object whose layers have failed has failed.
void failWithLayers(std::vector<BatchItem>& items) {
  for (const BatchItem& layer : items) {
    if (!layer.layer || layer.status != ItemStatus::Failed) continue;
    for (BatchItem& item : items) {
      if (item.source != layer.object) continue;
      item.status = ItemStatus::Failed;
      item.error = "its layer " + layer.source->name + ": " + layer.error;
    }
  }
}

/// Finds what is in the cache; everything else is skipped.
void lookUp(std::vector<BatchItem>& items, const TreeCache& cache, const builder::Progress& progress) {
  for (BatchItem& item : items) {
    if (item.status != ItemStatus::Waiting) continue;
    progress.check();
    item.key = item.job.key();
    std::optional<TreeResult> found = cache.find(item.key);
    item.status = found ? ItemStatus::Cached : ItemStatus::Skipped;
    if (found) item.result = std::move(*found);
  }
}

/// After all inputs are read and before the first build: declares everything that writeResults() writes.
void declareOutputs(const BatchSettings& settings, const Task& task, const std::vector<BatchItem>& items, const tool::RunFiles& files) {
  if (settings.draft) files.willMake(task.path);
  files.willMake(task.draft.ball, task.draft.ball_mesh);
  for (const char* name : {"scene.json", "report.json"}) files.willMake(settings.folder / name);
  for (const BatchItem& item : items)
    if (item.status != ItemStatus::Failed) files.willMake(settings.folder / item.treeName());
}

}  // namespace

BatchResult runBatch(const BatchSettings& settings, tool::WorkProgress& progress) {
  const auto begun = Clock::now();
  const tool::RunFiles files(progress);
  check(settings);
  const int threads = builder::usefulThreads(settings.threads);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  const bool is_plain = !settings.budget && !settings.speed;  // otherwise the amount of work is unknown in advance
  if (is_plain) progress.share(0, kReadShare);
  progress.stage("read");
  MeshStore meshes;
  Task task = taskOf(settings, meshes);
  formats::SceneFile& scene = task.scene;
  if (!settings.dry_run) files.makeFolder(settings.folder);
  const ToolPaths paths = readToolPaths(settings.paths);
  const TreeCache cache(settings.cache.empty() ? settings.folder / "cache" : settings.cache);
  std::vector<BatchItem> items = loadItems(scene, task.path, meshes, threads, progress);
  if (settings.shard.count == 1 && !settings.dry_run) declareOutputs(settings, task, items, files);
  const bool is_reference_named = !scene.tool.reference_point.empty();
  if (items[0].status != ItemStatus::Failed) resolveReferencePoint(scene.tool, items[0]);
  BatchContext context{scene, cache, threads, progress, assignWorkRegions(scene, items), is_plain || !settings.budget};
  const std::vector<BatchItem> source = items;
  BatchResult result;
  result.generator = tool::kGenerator;
  result.scene = task.path;
  result.is_reference_named = is_reference_named;
  result.notes = task.draft.notes;
  for (std::string& note : notesOnWork(context.work.get(), items)) result.notes.push_back(std::move(note));
  result.tool_distance_mm = items[0].status == ItemStatus::Failed ? 0 : distanceFrom(scene.tool.reference_point_mm, items[0]);
  if (is_plain) progress.share(kReadShare, 1 - kWriteShare);
  const auto read = Clock::now();
  if (settings.dry_run)
    lookUp(items, cache, progress);
  else if (settings.budget)
    result.budget = buildWithin(*settings.budget, items, paths, context);
  else
    buildItems(items, context, "build " + std::to_string(items.size()) + " trees", settings.shard);
  failWithLayers(items);
  const auto built = Clock::now();
  context.tell_finished = false;
  if (settings.speed) result.speed = speedRows(source, items, paths, context);
  if (settings.shard.count == 1 && !settings.dry_run) softenItems(items, cache, progress);
  for (BatchItem& item : items) result.objects.push_back(resultOf(item));
  const auto between = [](Clock::time_point a, Clock::time_point b) { return std::chrono::duration<double>(b - a).count(); };
  const auto ended = Clock::now();
  result.seconds = between(begun, ended);
  if (is_plain) progress.share(1 - kWriteShare, 1);
  if (settings.shard.count == 1 && !settings.dry_run) writeResults(settings, task, items, progress, result);
  result.times = {
      .read = between(begun, read), .build = between(read, built), .chart = between(built, ended), .write = between(ended, Clock::now())};
  return result;
}

}  // namespace spheretree::pipeline
