// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/batch_items.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <limits>
#include <map>
#include <mutex>
#include <thread>

#include "spheretree/formats/sphere_tree_file.h"

namespace spheretree::pipeline {
namespace {

void fail(BatchItem& item, const std::string& why) {
  item.status = ItemStatus::Failed;
  item.error = why;
}

/// Runs `work` and turns the exception of one bad object into its message. Cancelled is passed on.
template <class Work>
void guarded(BatchItem& item, Work&& work) {
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

/// Reads the item's mesh and computes its key; or reads its tree, which completes it.
void load(BatchItem& item, const formats::SceneFile& scene, const std::filesystem::path& scene_path, MeshStore& meshes) {
  const formats::SceneItem& source = *item.source;
  if (!source.tree.empty()) {
    item.result.tree = formats::readSphereTree(formats::scenePath(scene_path, source.tree));
    item.result.figures = figuresOf(item.result.tree);
    item.status = ItemStatus::Cached;
    return;
  }
  if (source.cut)
    for (const formats::CutLayer& layer : source.cut->layers) {  // refused here rather than when the tree is drilled
      formats::SceneItem inner = source;
      inner.mesh = layer.mesh;
      (void)meshes.read(scene, scene_path, inner);
    }
  const formats::TreeSettings settings = formats::mergedSettings(source.settings, scene.defaults);
  TreeJob& job = item.job;
  job.path = formats::scenePath(scene_path, source.mesh);
  job.file = meshes.read(scene, scene_path, source);
  job.part = source.part;
  job.repair = settings.repair.value_or("auto");
  job.settings = buildSettings(settings);
  if (source.soft && job.settings.builder == builder::BuilderKind::Cover) job.settings.soft_share = source.soft->share;
  job.pose = source.pose;
  job.triangles = trianglesOf(job.file->mesh.mesh, job.part, job.file->components);  // throws with the existing names
}

/// Estimated duration of the build, in arbitrary units.
double effortOf(const TreeJob& job) {
  std::size_t leaves = 1;
  for (int level = 1; level < job.settings.levels; ++level) leaves *= static_cast<std::size_t>(job.settings.branching);
  if (job.settings.max_leaves > 0) leaves = std::min(leaves, static_cast<std::size_t>(job.settings.max_leaves));
  return (4000 + static_cast<double>(job.triangles)) * (50 + static_cast<double>(leaves));
}

/// Objects that come as trees or cannot be read are left out: they do not block the way of the tool.
void findReach(WorkRegions& work, std::vector<BatchItem>& items, int threads, builder::Progress& progress) {
  progress.stage("reach");
  std::vector<TriangleMesh> solids(items.size());
  tbb::task_arena(threads).execute([&] {
    tbb::parallel_for(std::size_t{0}, items.size(), [&](std::size_t i) {
      if (items[i].is_tool || items[i].layer || !items[i].job.file || items[i].status == ItemStatus::Failed) return;
      try {
        solids[i] = inWorld(items[i].job.solid(progress).mesh, items[i].source->pose);
      } catch (const builder::BuildError&) {  // refused again later, with its reasons
      }
    });
    progress.check();
    std::erase_if(solids, [](const TriangleMesh& mesh) { return mesh.triangles.empty(); });
    if (!solids.empty()) work.space = std::make_unique<builder::ReachableSpace>(solids, work.reach->radius_mm, progress);
  });
}

/// Builds `items` in `order` with a pool of threads. The calling thread draws one progress bar and passes Ctrl-C on to
/// each build.
/// @throws builder::Cancelled
class WorkerPool {
 public:
  WorkerPool(std::vector<BatchItem>& items, const std::vector<double>& effort, const BatchContext& context)
      : items_(items), effort_(effort), cache_(context.cache), progress_(context.progress), tell_finished_(context.tell_finished) {}

  void run(const std::vector<std::size_t>& order, int threads) {
    for (const std::size_t i : order) total_ += effort_[i];
    count_ = order.size();
    std::thread workers([&] {
      tbb::task_arena arena(threads);
      arena.execute([&] {
        std::atomic<std::size_t> next{0};
        // Not a loop over the items: each thread takes the next one, so that the largest are started first.
        tbb::parallel_for(0, threads, 1, [&](int) {
          for (std::size_t k = next++; k < order.size() && !progress_.cancelled(); k = next++) build(order[k]);
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
        for (auto& [index, run] : running_) run.progress->cancel();
      show();
    }
    show();
    lock.unlock();
    workers.join();
    progress_.check();
  }

 private:
  using Clock = std::chrono::steady_clock;
  struct Run {
    builder::Progress* progress;
    Clock::time_point begun;
  };

  void build(std::size_t index) {
    BatchItem& item = items_[index];
    builder::Progress progress;
    const Clock::time_point begun = Clock::now();
    {
      const std::lock_guard lock(mutex_);
      running_.emplace(index, Run{&progress, begun});
    }
    try {
      guarded(item, [&] {
        item.result = item.job.run(progress);
        cache_.store(item.key, item.result);
        item.status = ItemStatus::Built;
      });
    } catch (const builder::Cancelled&) {  // the item is not changed
    }
    const std::lock_guard lock(mutex_);
    running_.erase(index);
    done_ += effort_[index];
    seconds_ += std::chrono::duration<double>(Clock::now() - begun).count();
    ended_.push_back(index);
    changed_.notify_one();
  }

  /// Must be called with the lock held, by the thread that may draw.
  void show() {
    for (; shown_ < ended_.size() && tell_finished_; ++shown_) {
      const BatchItem& item = items_[ended_[shown_]];
      if (item.status != ItemStatus::Built && item.status != ItemStatus::Failed) continue;
      progress_.finished({.name = item.source->name,
                          .is_built = item.status == ItemStatus::Built,
                          .leaves = item.result.figures.leaves,
                          .overhang_bound_mm = item.result.figures.leafBound(),
                          .seconds = item.result.seconds});
    }
    tool::WorkProgress::Objects objects{.done = ended_.size(), .count = count_, .running = {}};
    std::vector<std::pair<Clock::time_point, std::size_t>> at_work;
    for (const auto& [index, run] : running_) at_work.emplace_back(run.begun, index);
    std::sort(at_work.begin(), at_work.end());
    double done = done_;
    for (const auto& [begun, index] : at_work) {
      objects.running.push_back(items_[index].source->name);
      // Estimated at the rate so far; a build that takes longer than estimated stays just below its end.
      const double spent = std::chrono::duration<double>(Clock::now() - begun).count();
      if (seconds_ > 0) done += std::min(kNearlyDone * effort_[index], spent * done_ / seconds_);
    }
    told_ = total_ > 0 ? std::max(told_, done / total_) : 1;  // the fraction never decreases, even if the rate falls
    progress_.advance(told_, objects);
  }

  static constexpr double kNearlyDone = 0.95;
  std::vector<BatchItem>& items_;
  const std::vector<double>& effort_;  // for each item
  const TreeCache& cache_;
  tool::WorkProgress& progress_;
  const bool tell_finished_;
  std::mutex mutex_;  // protects everything below
  std::condition_variable changed_;
  std::map<std::size_t, Run> running_;  // by item
  std::vector<std::size_t> ended_;
  std::size_t shown_ = 0, count_ = 0;          // number of finished builds; number of all builds
  double done_ = 0, total_ = 0, seconds_ = 0;  // effort; duration of the finished builds
  double told_ = 0;                            // reported fraction
  bool finished_ = false;
};

/// "a, b, c and 4 more".
std::string firstOf(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  return names.size() > kShown ? text + " and " + std::to_string(names.size() - kShown) + " more" : text;
}

}  // namespace

std::shared_ptr<WorkRegions> assignWorkRegions(const formats::SceneFile& scene, std::vector<BatchItem>& items) {
  if (scene.work.empty() && !scene.reach) return nullptr;
  auto work = std::make_shared<WorkRegions>();
  work->regions = scene.work;
  work->reach = scene.reach;
  if (scene.reach) {  // what one object blocks depends on the poses of all others
    formats::SceneFile only;
    only.reach = scene.reach;
    only.tool.name = "tool";
    for (const BatchItem& item : items)
      if (!item.is_tool && item.status == ItemStatus::Waiting) {
        formats::SceneItem place;
        place.name = item.job.meshKey();
        place.pose = item.source->pose;
        only.objects.push_back(place);
      }
    work->reach_key = formats::sceneText(only);
  }
  for (BatchItem& item : items)
    if (!item.is_tool && item.status == ItemStatus::Waiting) item.job.grade(work);
  return work;
}

std::vector<std::string> notesOnWork(const WorkRegions* work, const std::vector<BatchItem>& items) {
  std::vector<std::string> notes;
  if (!work) return notes;
  for (std::size_t i = 0; i < work->regions.size(); ++i) {
    const formats::WorkRegion& region = work->regions[i];
    const BatchItem* nearest = nullptr;
    double distance = std::numeric_limits<double>::infinity();
    for (const BatchItem& item : items) {
      const double own = item.job.work ? distanceOf(region, item.job.world_box) : std::numeric_limits<double>::infinity();
      if (own < distance) distance = own, nearest = &item;
    }
    char away[32];
    std::snprintf(away, sizeof away, "%.4g", distance);
    if (nearest && distance > 0)
      notes.push_back("work[" + std::to_string(i) + "]" + (region.name.empty() ? "" : " (" + region.name + ")") +
                      " touches no object: the nearest is " + nearest->source->name + ", " + away +
                      " mm away. Check its place; it is in the frame of the world.");
  }
  std::vector<std::string> without_search, without_tolerance;  // names of objects
  for (const BatchItem& item : items) {
    if (!item.job.work) continue;
    const bool is_concerned = work->reach || std::any_of(work->regions.begin(), work->regions.end(),
                                                         [&](const auto& region) { return distanceOf(region, item.job.world_box) <= 0; });
    if (!is_concerned) continue;
    if (!item.job.settings.searches())
      without_search.push_back(item.source->name);
    else if (!(item.job.settings.tolerance_mm > 0))
      without_tolerance.push_back(item.source->name);
  }
  const std::string what = work->regions.empty() ? "reach has" : work->reach ? "work and reach have" : "work has";
  if (!without_search.empty())
    notes.push_back(what + " no effect on " + firstOf(without_search) +
                    ": a published builder makes the leaves of its method. Add \"search\": true, or take the builder cover.");
  if (!without_tolerance.empty())
    notes.push_back(what + " no effect on " + firstOf(without_tolerance) + ": without a tolerance_mm all leaves are used. Give one.");
  return notes;
}

std::string layerName(const formats::SceneItem& object, const formats::CutLayer& layer) { return object.name + "." + layer.name; }

namespace {

/// The layers within the objects; the first layer is the object itself.
void addLayers(const formats::SceneFile& scene, std::vector<BatchItem>& items) {
  for (const formats::SceneItem& object : scene.objects)
    for (std::size_t k = 1; object.cut && k < object.cut->layers.size(); ++k) {
      const formats::CutLayer& layer = object.cut->layers[k];
      auto own = std::make_shared<formats::SceneItem>();
      own->name = layerName(object, layer);
      own->mesh = layer.tree.empty() ? layer.mesh : std::filesystem::path();
      own->tree = layer.tree;
      own->unit = object.unit;
      own->pose = object.pose;
      own->settings = object.settings;
      own->settings.quality = "quick";  // the runtime takes its skin alone
      BatchItem& item = items.emplace_back();
      item.source = own.get();
      item.object = &object;
      item.layer = std::move(own);
    }
}

}  // namespace

std::vector<BatchItem> loadItems(const formats::SceneFile& scene, const std::filesystem::path& scene_path, MeshStore& meshes, int threads,
                                 builder::Progress& progress) {
  std::vector<BatchItem> items(1 + scene.objects.size());
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].source = i == 0 ? &scene.tool : &scene.objects[i - 1];
    items[i].is_tool = i == 0;
  }
  addLayers(scene, items);
  std::atomic<std::size_t> done{0};
  tbb::task_arena(threads).execute([&] {
    const std::thread::id draws = std::this_thread::get_id();
    tbb::parallel_for(std::size_t{0}, items.size(), [&](std::size_t i) {
      if (!progress.cancelled()) guarded(items[i], [&] { load(items[i], scene, scene_path, meshes); });
      const std::size_t now = ++done;
      if (std::this_thread::get_id() == draws) progress.advance(static_cast<double>(now) / static_cast<double>(items.size()));
    });
  });
  progress.check();
  return items;
}

std::size_t maxLeaves(const formats::SceneFile& scene, const BatchItem& item) {
  const int levels = formats::mergedSettings(item.source->settings, scene.defaults).levels.value_or(kMaxLevels);
  std::size_t largest = 1;
  for (int level = 1; level < levels; ++level) largest *= static_cast<std::size_t>(item.job.settings.branching);
  return largest;
}

void limitLeaves(builder::BuildSettings& settings, std::size_t leaves) {
  const auto branching = static_cast<std::size_t>(settings.branching);
  settings.max_leaves = static_cast<int>(leaves);
  settings.levels = kMinLevels;
  for (std::size_t full = branching; full < leaves; full *= branching) ++settings.levels;
}

void buildItems(std::vector<BatchItem>& items, const BatchContext& context, const std::string& stage, const Shard& shard) {
  // Identical items are built once; the duplicates wait and then take that result.
  std::vector<std::size_t> order, duplicates;
  std::map<std::string, std::size_t> first_of;
  std::vector<double> effort(items.size(), 0);
  for (std::size_t i = 0; i < items.size(); ++i) {
    BatchItem& item = items[i];
    if (item.status != ItemStatus::Waiting) continue;
    item.key = item.job.key();
    if (std::optional<TreeResult> found = context.cache.find(item.key)) {
      item.result = std::move(*found);
      item.status = ItemStatus::Cached;
      continue;
    }
    effort[i] = effortOf(item.job);
    const bool is_first = first_of.emplace(item.key, i).second;
    (is_first ? order : duplicates).push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return effort[a] > effort[b]; });
  if (shard.count > 1) {
    // Assigns shards by key instead of by position in the remaining work: other shards may have finished some of it.
    std::erase_if(order, [&](std::size_t i) {
      std::uint64_t digits = 0;
      std::from_chars(items[i].key.data(), items[i].key.data() + 15, digits, 16);
      return digits % shard.count != shard.index - 1;
    });
  }
  if (!order.empty()) context.cache.prepare();
  WorkRegions* work = context.work.get();
  if (work && work->reach && !work->space && !order.empty()) findReach(*work, items, context.threads, context.progress);
  context.progress.stage(stage);
  WorkerPool(items, effort, context).run(order, context.threads);
  for (const std::size_t i : duplicates) {
    const BatchItem& first = items[first_of.at(items[i].key)];
    items[i].result = first.result;
    items[i].error = first.error;
    items[i].status = first.status;
  }
  for (BatchItem& item : items)
    if (item.status == ItemStatus::Waiting) item.status = ItemStatus::Skipped;
}

}  // namespace spheretree::pipeline
