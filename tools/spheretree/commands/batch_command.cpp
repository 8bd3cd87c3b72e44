// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree batch: every object of a scene to trees, with a compiled scene and a report.
#include <tbb/global_control.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <thread>

#include "batch/batch_budget.h"
#include "batch/batch_chart.h"
#include "batch/batch_items.h"
#include "batch/tree_job.h"
#include "commands/command.h"
#include "commands/common_options.h"
#include "json_text.h"
#include "output_path.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::tool {
namespace {

using Clock = std::chrono::steady_clock;

struct BatchOptions {
  std::filesystem::path scene, folder, cache;
  Shard shard;
  int threads = 0;
  std::optional<Budget> budget;
  bool chart = false;
  std::vector<std::filesystem::path> hands;  // trajectories or recordings
};

/// What a batch found out beyond its trees; null if it was not asked for.
struct Findings {
  Json budget, pareto;
};

const char* name(ItemStatus status) {
  switch (status) {
    case ItemStatus::Built:
      return "built";
    case ItemStatus::Cached:
      return "cached";
    case ItemStatus::Failed:
      return "failed";
    default:
      return "skipped";
  }
}

/// The scene that the player loads: trees in place of meshes, and only those there are.
formats::SceneFile compiledScene(const formats::SceneFile& scene, const std::vector<Item>& items) {
  formats::SceneFile out = scene;
  out.unit = "mm";
  out.defaults = {};
  out.objects.clear();
  for (const Item& item : items) {
    if (item.status == ItemStatus::Failed) continue;
    formats::SceneItem compiled = *item.source;
    compiled.mesh.clear();
    compiled.part.clear();
    compiled.settings = {};
    compiled.tree = compiled.name + ".stree";
    if (item.is_tool)
      out.tool = std::move(compiled);
    else
      out.objects.push_back(std::move(compiled));
  }
  return out;
}

/// Of the leaves that its levels and branching allow, those that a tolerance made needless.
std::size_t savedLeaves(const Item& item) {
  if (item.key.empty() || item.job.settings.most_leaves > 0 || !(item.job.settings.tolerance_mm > 0)) return 0;
  std::size_t budget = 1;
  for (int level = 1; level < item.job.settings.levels; ++level) budget *= static_cast<std::size_t>(item.job.settings.branching);
  return budget - std::min(budget, item.result.record.at("leaves").get<std::size_t>());
}

Json reportOf(const BatchOptions& options, const std::vector<Item>& items, const Findings& findings, double seconds) {
  Json objects = Json::array();
  std::size_t counts[3] = {}, triangles = 0, leaves = 0, saved = 0, nodes = 0, bytes = 0;
  double worst = 0;
  for (const Item& item : items) {
    Json entry{{"name", item.source->name}, {"role", item.is_tool ? "tool" : "object"}, {"status", name(item.status)}};
    if (item.status == ItemStatus::Failed) {
      entry["error"] = item.error;
      ++counts[2];
    } else {
      ++counts[item.status == ItemStatus::Cached];
      entry["seconds"] = item.result.seconds;
      entry.update(item.result.record);
      entry["saved_leaves"] = savedLeaves(item);
      entry["tree"] = item.source->name + ".stree";
      entry["bytes"] = encodeSphereTree(item.result.tree).size();
      triangles += entry["triangles"].get<std::size_t>();
      leaves += entry["leaves"].get<std::size_t>();
      saved += entry["saved_leaves"].get<std::size_t>();
      nodes += entry["nodes"].get<std::size_t>();
      bytes += entry["bytes"].get<std::size_t>();
      const Json& bound = entry["levels"].back()["overhang_mm"]["bound"];
      if (bound.is_number()) worst = std::max(worst, bound.get<double>());
    }
    objects.push_back(std::move(entry));
  }
  Json out{{"schema", "spheretree.batch/1"},
           {"generator", kGenerator},
           {"scene", options.scene.string()},
           {"objects", objects},
           {"totals",
            {{"objects", items.size()},
             {"built", counts[0]},
             {"cached", counts[1]},
             {"failed", counts[2]},
             {"triangles", triangles},
             {"leaves", leaves},
             {"saved_leaves", saved},
             {"nodes", nodes},
             {"bytes", bytes},
             {"overhang_bound_mm", worst},
             {"seconds", seconds}}}};
  if (!findings.budget.is_null()) out["budget"] = findings.budget;
  if (!findings.pareto.is_null()) out["pareto"] = findings.pareto;
  return out;
}

void writeResults(const BatchOptions& options, const formats::SceneFile& scene, const std::vector<Item>& items, const Findings& findings,
                  double seconds) {
  for (const Item& item : items)
    if (item.status != ItemStatus::Failed) formats::writeSphereTree(options.folder / (item.source->name + ".stree"), item.result.tree);
  const formats::SceneFile compiled = compiledScene(scene, items);
  // Without a tool or any object there is no scene to load, and an older one would pass for this one.
  if (items[0].status == ItemStatus::Failed || compiled.objects.empty())
    std::filesystem::remove(options.folder / "scene.json");
  else
    formats::writeWhole(options.folder / "scene.json", formats::sceneText(compiled));
  formats::writeWhole(options.folder / "report.json", jsonText(reportOf(options, items, findings, seconds), 1) + "\n");
}

/// Of a budget, in words; false if it is not kept.
bool printBudget(const Json& budget) {
  const bool is_time = budget.at("of") == "us", met = budget.at("met").get<bool>();
  std::printf("budget: %.6g of %.6g %s", budget.at("spent").get<double>(), budget.at("amount").get<double>(),
              is_time ? "us a step (99th percentile, by the model)" : "leaves");
  if (budget.contains("worst_ratio"))
    std::printf("; largest error %.4g times its tolerance (or mm without one)", budget.at("worst_ratio").get<double>());
  std::printf("\n");
  if (!met) std::cerr << "spheretree: the budget is not met; the cheapest trees found were written. Allow more.\n";
  return met;
}

int printResults(const BatchOptions& options, const std::vector<Item>& items, const Findings& findings, bool whole) {
  std::size_t counts[5] = {}, leaves = 0, missed = 0;
  for (const Item& item : items) {
    ++counts[static_cast<std::size_t>(item.status)];
    if (item.status == ItemStatus::Failed) std::cerr << "spheretree: " << item.source->name << ": " << item.error << '\n';
    if (item.status == ItemStatus::Failed || item.status == ItemStatus::Skipped) continue;
    leaves += item.result.record.at("leaves").get<std::size_t>();
    if (item.result.record.at("tolerance_met") != false) continue;
    if (options.budget) continue;  // that is what the budget costs; the report says it
    ++missed;
    std::cerr << "spheretree: " << item.source->name << ": the tolerance of " << item.result.record.at("tolerance_mm")
              << " mm is not met; the best result was written. Allow more levels or a larger tolerance_mm.\n";
  }
  const auto count = [&](ItemStatus status) { return counts[static_cast<std::size_t>(status)]; };
  std::printf("%s: %zu built, %zu unchanged, %zu failed", options.folder.c_str(), count(ItemStatus::Built), count(ItemStatus::Cached),
              count(ItemStatus::Failed));
  if (whole)
    std::printf("; %zu leaves\n", leaves);
  else
    std::printf("; %zu left to other shards. Run without --shard once all have ended.\n", count(ItemStatus::Skipped));
  if (!findings.budget.is_null() && !printBudget(findings.budget)) ++missed;
  if (count(ItemStatus::Failed) > 0) return kExitPartlyFailed;
  return missed > 0 ? kExitTargetMissed : kExitOk;
}

void checkOptions(const BatchOptions& options) {
  if (options.shard.count > 1 && options.budget) throw UsageError("--budget needs all objects at once. Leave --shard out.");
  if (options.shard.count > 1 && options.chart)
    throw UsageError("--chart belongs to the run that writes the results. Leave out --shard or --chart.");
  if (!options.hands.empty() && !options.chart && !(options.budget && options.budget->is_time))
    throw UsageError("--trajectory is for --chart and for a --budget in us. Leave it out, or add one of them.");
}

int batch(BatchOptions options, builder::Progress& progress) {
  const auto begun = Clock::now();
  checkOptions(options);
  if (options.cache.empty()) options.cache = options.folder / "cache";
  const int threads = options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  const formats::SceneFile scene = formats::readScene(options.scene);
  formats::makeFolder(options.folder);
  checkOutput(options.folder / "scene.json", {options.scene});
  checkOutput(options.folder / "report.json", {options.scene});

  progress.stage("read");
  const Hands hands = readHands(options.hands);
  MeshStore meshes;
  const TreeCache cache(options.cache);
  const Workshop workshop{cache, threads, progress};
  std::vector<Item> items = loadItems(scene, options.scene, meshes, threads, progress);
  const std::shared_ptr<WorkSite> site = giveSite(scene, items);
  const std::vector<Item> source = items;
  Findings findings;
  if (options.budget)
    findings.budget = buildWithin(*options.budget, scene, items, site.get(), hands, workshop);
  else
    buildItems(items, site.get(), workshop, "build " + std::to_string(items.size()) + " trees", options.shard);
  if (options.chart) findings.pareto = paretoOf(scene, source, items, site.get(), hands, workshop);
  const bool whole = options.shard.count == 1;
  if (whole) writeResults(options, scene, items, findings, std::chrono::duration<double>(Clock::now() - begun).count());
  return printResults(options, items, findings, whole);
}

int runBatch(const BatchOptions& options, builder::Progress& progress) try {
  return batch(options, progress);
} catch (const builder::Cancelled&) {
  std::cerr << "spheretree: interrupted. The trees that were finished are kept; the same command goes on from there.\n";
  return kExitInterrupted;
}

std::string parseBudget(const std::string& text, std::optional<Budget>& budget) {
  Budget parsed;
  const char* end = text.data() + text.size();
  const auto [unit, error] = std::from_chars(text.data(), end, parsed.amount);
  parsed.is_time = std::string_view(unit, end) == "us";
  const bool is_number = error == std::errc() && std::isfinite(parsed.amount) && parsed.amount > 0;
  const bool is_count = unit == end && parsed.amount >= 1 && parsed.amount <= 1e9 && parsed.amount == std::floor(parsed.amount);
  if (!is_number || !(parsed.is_time || is_count)) return text + " is neither a number of leaves, as 6000, nor a time, as 20us";
  budget = parsed;
  return "";
}

std::string parseShard(const std::string& text, Shard& shard) {
  const char* end = text.data() + text.size();
  const auto [slash, bad_index] = std::from_chars(text.data(), end, shard.index);
  if (bad_index == std::errc() && slash != end && *slash == '/') {
    const auto [last, bad_count] = std::from_chars(slash + 1, end, shard.count);
    if (bad_count == std::errc() && last == end && shard.index >= 1 && shard.index <= shard.count && shard.count <= 10000) return "";
  }
  return text + " is not I/N with 1 <= I <= N <= 10000";
}

}  // namespace

void addBatchCommand(Program& program) {
  const auto options = std::make_shared<BatchOptions>();
  CLI::App* app = addVerb(program, "batch", "Build the trees of every object of a scene; what has not changed is taken from a cache",
                          "spheretree batch mouth.scene.json -o mouth",
                          [options](builder::Progress& progress) { return runBatch(*options, progress); });
  app->add_option("SCENE", options->scene, "Scene to read (.scene.json); see docs/scene_file.md")->required()->type_name("FILE");
  app->add_option("-o,--output", options->folder, "Folder for NAME.stree, scene.json and report.json; made if it is missing")
      ->required()
      ->type_name("DIR");
  app->add_option("--cache", options->cache, "Folder of finished trees, by content; default DIR/cache")->type_name("DIR");
  app->add_option_function<std::string>(
         "--shard", [options](const std::string& text) { (void)parseShard(text, options->shard); },
         "Build only the I-th of N shares, into the cache; default 1/1: all, and write the results")
      ->type_name("I/N")
      ->check([](const std::string& text) {
        Shard ignored;
        return parseShard(text, ignored);
      });
  app->add_option_function<std::string>(
         "--budget", [options](const std::string& text) { (void)parseBudget(text, options->budget); },
         "The least worst error for so many LEAVES in all, 1 to 10^9, or for so many microseconds of each step, above 0, by a model that "
         "is "
         "the same on every machine (as 20us); default: none, each object has its own levels and tolerance")
      ->type_name("LEAVES|US")
      ->check([](const std::string& text) {
        std::optional<Budget> ignored;
        return parseBudget(text, ignored);
      });
  app->add_flag(
      "--chart", options->chart,
      "Also measure the scene and each object with 8 to 4,096 leaves and with each tolerance of the scene, for the chart of speed "
      "against accuracy in the report; default: not");
  app->add_option("--trajectory", options->hands,
                  "Trajectory or recording (.csv) of the hand whose steps --chart and a --budget in us count; may be given again; default: "
                  "touches at random")
      ->type_name("FILE")
      ->allow_extra_args(false);
  addThreads(*app, options->threads);
}

}  // namespace spheretree::tool
