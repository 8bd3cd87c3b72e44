// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree batch: every object of a scene to trees, with a compiled scene and a report.
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <iostream>
#include <mutex>
#include <numeric>
#include <set>
#include <thread>

#include "command.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/scene_file.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "tree_job.h"

namespace spheretree::tool {
namespace {

using Clock = std::chrono::steady_clock;

struct Shard {
  std::size_t index = 1, count = 1;
};

struct BatchOptions {
  std::filesystem::path scene, folder, cache;
  Shard shard;
  int threads = 0;
};

enum class Status { Waiting, Built, Cached, Failed, Skipped };

const char* name(Status status) {
  switch (status) {
    case Status::Built:
      return "built";
    case Status::Cached:
      return "cached";
    case Status::Failed:
      return "failed";
    default:
      return "skipped";
  }
}

/// The tool (first) or an object on its way to a tree.
struct Item {
  const formats::SceneItem* source = nullptr;
  bool is_tool = false;
  TreeJob job;
  std::string key;
  double work = 0;  // how long it will take, in no particular unit
  Status status = Status::Waiting;
  std::string error;
  TreeResult result;
};

void fail(Item& item, const std::string& why) {
  item.status = Status::Failed;
  item.error = why;
}

/// Runs `work` and turns what one bad object throws into its message. Cancelled goes on up.
template <class Work>
void guarded(Item& item, Work&& work) {
  try {
    work();
  } catch (const builder::Cancelled&) {
    throw;
  } catch (const std::bad_alloc&) {
    fail(item, "not enough memory. Use fewer --threads or a smaller mesh.");
  } catch (const std::exception& error) {
    fail(item, error.what());
  }
}

std::vector<Item> itemsOf(const formats::SceneFile& scene) {
  std::vector<Item> items(1 + scene.objects.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].source = i == 0 ? &scene.tool : &scene.objects[i - 1];
    items[i].is_tool = i == 0;
  }
  return items;
}

/// Reads the item's mesh and finds its key; or reads its tree, and it is done.
void load(Item& item, const formats::SceneFile& scene, const BatchOptions& options, MeshStore& meshes) {
  const formats::SceneItem& source = *item.source;
  if (!source.tree.empty()) {
    item.result.tree = formats::readSphereTree(formats::scenePath(options.scene, source.tree));
    const SphereTree& tree = item.result.tree;
    Json levels = Json::array();
    for (std::size_t level = 0; level < tree.statistics.size(); ++level) {
      const float bound = tree.statistics[level].overhang_bound;
      levels.push_back({{"level", level},
                        {"spheres", tree.statistics[level].sphere_count},
                        {"overhang_mm", {{"bound", bound == kUnproven ? Json(nullptr) : Json(bound)}}}});
    }
    item.result.record = {{"triangles", tree.provenance.triangle_count},
                          {"leaves", tree.statistics.back().sphere_count},
                          {"nodes", tree.nodeCount()},
                          {"diagonal_mm", tree.provenance.diagonal_mm},
                          {"tolerance_mm", nullptr},
                          {"tolerance_met", nullptr},
                          {"certified", tree.statistics.back().overhang_bound != kUnproven},
                          {"repair", Json::array()},
                          {"notes", Json::array()},
                          {"levels", levels}};
    item.status = Status::Cached;
    return;
  }
  const formats::TreeSettings settings = formats::mergedSettings(source.settings, scene.defaults);
  TreeJob& job = item.job;
  job.path = formats::scenePath(options.scene, source.mesh);
  job.file = meshes.read(job.path, formats::unitInMm(scene.unit));
  job.part = source.part;
  job.repair = settings.repair.value_or("auto");
  job.settings = buildSettings(settings);
  job.pose = source.pose;
  const std::vector<std::string>& parts = job.file->mesh.mesh.part_names;
  if (!job.part.empty() && std::find(parts.begin(), parts.end(), job.part) == parts.end())
    (void)formats::selectPart(job.file->mesh.mesh, job.part);  // says which parts there are
  std::size_t triangles = job.file->mesh.mesh.triangles.size();
  if (!job.part.empty()) {
    const auto index = static_cast<std::uint32_t>(std::find(parts.begin(), parts.end(), job.part) - parts.begin());
    const auto& part = job.file->mesh.mesh.part;
    triangles = static_cast<std::size_t>(std::count(part.begin(), part.end(), index));
  }
  item.work = 4000 + static_cast<double>(triangles);
}

/// Null if the scene says nothing about where accuracy is needed.
std::shared_ptr<WorkSite> workSite(const formats::SceneFile& scene, const std::vector<Item>& items) {
  if (scene.work.empty() && !scene.reach) return nullptr;
  auto site = std::make_shared<WorkSite>();
  site->regions = scene.work;
  site->reach = scene.reach;
  formats::SceneFile only;  // the scene's own text of regions and reach
  only.work = scene.work;
  only.reach = scene.reach;
  only.tool.name = "tool";
  site->key = formats::sceneText(only);
  if (scene.reach)  // what one object shuts off depends on where all others are
    for (const Item& item : items)
      if (!item.is_tool && item.status == Status::Waiting) {
        formats::SceneItem place;
        place.name = item.job.key();
        place.pose = item.source->pose;
        only.objects.push_back(place);
      }
  site->key += formats::sceneText(only);
  return site;
}

/// What comes as a tree, or cannot be read, is left out: it shuts nothing off.
void findReach(WorkSite& site, std::vector<Item>& items, int threads, builder::Progress& progress) {
  progress.stage("reach");
  std::vector<TriangleMesh> solids(items.size());
  tbb::task_arena(threads).execute([&] {
    tbb::parallel_for(std::size_t{0}, items.size(), [&](std::size_t i) {
      if (items[i].is_tool || !items[i].job.file || items[i].status == Status::Failed) return;
      try {
        std::vector<std::string> ignored;
        solids[i] = inWorld(items[i].job.solid(ignored, progress).mesh, items[i].source->pose);
      } catch (const builder::BuildError&) {  // refused again, with its reasons, when its turn comes
      }
    });
    progress.check();
    std::erase_if(solids, [](const TriangleMesh& mesh) { return mesh.triangles.empty(); });
    if (!solids.empty()) site.space = std::make_unique<builder::ReachableSpace>(solids, site.reach->radius_mm, progress);
  });
}

/// Runs `items` in `order` on all threads of this arena, draws one bar, and hands Ctrl-C on to each. @throws builder::Cancelled
class Crew {
 public:
  Crew(std::vector<Item>& items, const TreeCache& cache, builder::Progress& progress) : items_(items), cache_(cache), progress_(progress) {}

  void run(const std::vector<std::size_t>& order, int threads) {
    for (const std::size_t i : order) total_ += items_[i].work;
    progress_.stage("build " + std::to_string(order.size()) + (order.size() == 1 ? " object" : " objects"));
    std::thread boss([&] {
      tbb::task_arena arena(threads);
      arena.execute([&] {
        std::atomic<std::size_t> next{0};
        // Not a loop over the items: each thread takes the next one, so that the biggest begin first.
        tbb::parallel_for(0, threads, 1, [&](int) {
          for (std::size_t k = next++; k < order.size() && !progress_.cancelled(); k = next++) build(items_[order[k]]);
        });
      });
      const std::lock_guard lock(mutex_);
      finished_ = true;
      changed_.notify_one();
    });
    std::unique_lock lock(mutex_);
    while (!finished_) {
      changed_.wait_for(lock, std::chrono::milliseconds(100));
      if (progress_.cancelled())
        for (builder::Progress* running : running_) running->cancel();
      progress_.advance(total_ > 0 ? done_ / total_ : 1);
    }
    lock.unlock();
    boss.join();
    progress_.check();
  }

 private:
  void build(Item& item) {
    builder::Progress progress;
    {
      const std::lock_guard lock(mutex_);
      running_.insert(&progress);
    }
    try {
      guarded(item, [&] {
        item.result = item.job.run(progress);
        cache_.store(item.key, item.result);
        item.status = Status::Built;
      });
    } catch (const builder::Cancelled&) {  // the item stays as it is
    }
    const std::lock_guard lock(mutex_);
    running_.erase(&progress);
    done_ += item.work;
    changed_.notify_one();
  }

  std::vector<Item>& items_;
  const TreeCache& cache_;
  builder::Progress& progress_;
  std::mutex mutex_;  // over all below
  std::condition_variable changed_;
  std::set<builder::Progress*> running_;
  double done_ = 0, total_ = 0;
  bool finished_ = false;
};

/// The scene that the player loads: trees in place of meshes, and only those there are.
formats::SceneFile compiledScene(const formats::SceneFile& scene, const std::vector<Item>& items) {
  formats::SceneFile out = scene;
  out.unit = "mm";
  out.defaults = {};
  out.objects.clear();
  for (const Item& item : items) {
    if (item.status == Status::Failed) continue;
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
  if (item.key.empty() || !(item.job.settings.tolerance_mm > 0)) return 0;
  std::size_t budget = 1;
  for (int level = 1; level < item.job.settings.levels; ++level) budget *= static_cast<std::size_t>(item.job.settings.branching);
  return budget - std::min(budget, item.result.record.at("leaves").get<std::size_t>());
}

Json reportOf(const BatchOptions& options, const std::vector<Item>& items, double seconds) {
  Json objects = Json::array();
  std::size_t counts[3] = {}, triangles = 0, leaves = 0, saved = 0, nodes = 0, bytes = 0;
  double worst = 0;
  for (const Item& item : items) {
    Json entry{{"name", item.source->name}, {"role", item.is_tool ? "tool" : "object"}, {"status", name(item.status)}};
    if (item.status == Status::Failed) {
      entry["error"] = item.error;
      ++counts[2];
    } else {
      ++counts[item.status == Status::Cached];
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
  return {{"schema", "spheretree.batch/1"},
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
}

void writeResults(const BatchOptions& options, const formats::SceneFile& scene, const std::vector<Item>& items, double seconds) {
  for (const Item& item : items)
    if (item.status != Status::Failed) formats::writeSphereTree(options.folder / (item.source->name + ".stree"), item.result.tree);
  const formats::SceneFile compiled = compiledScene(scene, items);
  // Without a tool or any object there is no scene to load, and an older one would pass for this one.
  if (items[0].status == Status::Failed || compiled.objects.empty())
    std::filesystem::remove(options.folder / "scene.json");
  else
    formats::writeWhole(options.folder / "scene.json", formats::sceneText(compiled));
  formats::writeWhole(options.folder / "report.json", reportOf(options, items, seconds).dump(1) + "\n");
}

int printResults(const BatchOptions& options, const std::vector<Item>& items, bool whole) {
  std::size_t counts[5] = {}, leaves = 0, missed = 0;
  for (const Item& item : items) {
    ++counts[static_cast<std::size_t>(item.status)];
    if (item.status == Status::Failed) std::cerr << "spheretree: " << item.source->name << ": " << item.error << '\n';
    if (item.status == Status::Failed || item.status == Status::Skipped) continue;
    leaves += item.result.record.at("leaves").get<std::size_t>();
    if (item.result.record.at("tolerance_met") != false) continue;
    ++missed;
    std::cerr << "spheretree: " << item.source->name << ": the tolerance of " << item.result.record.at("tolerance_mm")
              << " mm is not met; the best result was written. Allow more levels or a larger tolerance_mm.\n";
  }
  const auto count = [&](Status status) { return counts[static_cast<std::size_t>(status)]; };
  std::printf("%s: %zu built, %zu unchanged, %zu failed", options.folder.c_str(), count(Status::Built), count(Status::Cached),
              count(Status::Failed));
  if (whole)
    std::printf("; %zu leaves\n", leaves);
  else
    std::printf("; %zu left to other shards. Run without --shard once all have ended.\n", count(Status::Skipped));
  if (count(Status::Failed) > 0) return kExitPartlyFailed;
  return missed > 0 ? kExitTargetMissed : kExitOk;
}

int batch(BatchOptions options, builder::Progress& progress) {
  const auto begun = Clock::now();
  if (options.cache.empty()) options.cache = options.folder / "cache";
  const int threads = options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  const formats::SceneFile scene = formats::readScene(options.scene);
  std::error_code error;
  std::filesystem::create_directories(options.folder, error);
  if (error) throw formats::FileError(options.folder.string() + ": cannot be made: " + error.message() + ". Choose another folder.");
  formats::checkWritable(options.folder / "report.json");

  progress.stage("read");
  std::vector<Item> items = itemsOf(scene);
  MeshStore meshes;
  const TreeCache cache(options.cache);
  tbb::task_arena(threads).execute([&] {
    tbb::parallel_for(std::size_t{0}, items.size(), [&](std::size_t i) {
      Item& item = items[i];
      if (progress.cancelled()) return;
      guarded(item, [&] { load(item, scene, options, meshes); });
    });
  });
  progress.check();
  const std::shared_ptr<WorkSite> site = workSite(scene, items);
  for (Item& item : items) {
    if (item.status != Status::Waiting) continue;
    if (!item.is_tool) item.job.site = site;
    item.key = item.job.key();
    if (std::optional<TreeResult> found = cache.find(item.key)) {
      item.result = std::move(*found);
      item.status = Status::Cached;
    }
  }

  // The same object twice is built once: the second waits and then finds it.
  std::vector<std::size_t> order, twins;
  std::map<std::string, std::size_t> first_of;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (items[i].status != Status::Waiting) continue;
    const bool is_first = first_of.emplace(items[i].key, i).second;
    (is_first ? order : twins).push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return items[a].work > items[b].work; });
  const bool whole = options.shard.count == 1;
  if (!whole) {
    // Shares by key and not by place in what is left to do: other shards may have finished some of it.
    const auto isOurs = [&](std::size_t i) {
      std::uint64_t digits = 0;
      std::from_chars(items[i].key.data(), items[i].key.data() + 15, digits, 16);
      return digits % options.shard.count == options.shard.index - 1;
    };
    std::erase_if(order, [&](std::size_t i) { return !isOurs(i); });
  }
  if (site && site->reach && !order.empty()) findReach(*site, items, threads, progress);
  Crew(items, cache, progress).run(order, threads);
  for (const std::size_t i : twins) {
    const Item& first = items[first_of.at(items[i].key)];
    items[i].result = first.result;
    items[i].error = first.error;
    items[i].status = first.status;
  }
  for (Item& item : items)
    if (item.status == Status::Waiting) item.status = Status::Skipped;
  if (whole) writeResults(options, scene, items, std::chrono::duration<double>(Clock::now() - begun).count());
  return printResults(options, items, whole);
}

int runBatch(const BatchOptions& options, builder::Progress& progress) try {
  return batch(options, progress);
} catch (const builder::Cancelled&) {
  std::cerr << "spheretree: interrupted. The trees that were finished are kept; the same command goes on from there.\n";
  return kExitInterrupted;
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
  app->add_option("--threads", options->threads,
                  "Threads, 0 to 1024; 0: as many as the machine has; default 0. The result is the same for any")
      ->type_name("N")
      ->check(CLI::Range(0, 1024));
}

}  // namespace spheretree::tool
