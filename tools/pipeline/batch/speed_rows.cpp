// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/speed_rows.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "spheretree/runtime/scene.h"
#include "upper_levels.h"

namespace spheretree::pipeline {
namespace {

constexpr std::size_t kMaxLeaves = 4096;  // 8^4: the leaves of a tree of five levels
constexpr std::size_t kObjectContacts = 40;

/// The setting of a row: a number of leaves that no tree exceeds, a tolerance, or neither: the chosen trees.
struct Setting {
  std::size_t leaves = 0;
  double tolerance = 0;
  bool chosen() const { return leaves == 0 && tolerance == 0; }
};

/// The tolerances of the items that are to be built.
std::set<double> tolerancesOf(const std::vector<BatchItem>& source) {
  std::set<double> tolerances;
  for (const BatchItem& item : source)
    if (item.status == ItemStatus::Waiting && item.job.settings.tolerance_mm > 0) tolerances.insert(item.job.settings.tolerance_mm);
  return tolerances;
}

/// The items as they were read, to be built as quick trees with as many full levels as kMaxLeaves and the scene allow.
/// The skin is that of the chosen tree, since the tool rests on it whatever the leaves are.
std::vector<BatchItem> deepItems(const formats::SceneFile& scene, const std::vector<BatchItem>& source) {
  std::vector<BatchItem> items = source;
  for (BatchItem& item : items) {
    if (item.status != ItemStatus::Waiting) continue;
    builder::BuildSettings& settings = item.job.settings;
    if (settings.skin_tolerance_mm == 0) settings.skin_tolerance_mm = settings.tolerance_mm;
    limitLeaves(settings, std::min(kMaxLeaves, maxLeaves(scene, item)));
    settings.max_leaves = 0;
    settings.tolerance_mm = 0;
    settings.quality = builder::Quality::Quick;
    item.job.work = nullptr;
  }
  return items;
}

/// The items to build with this tolerance everywhere: quick trees, without regions of work. An item whose chosen tree
/// was built for just that is taken from `chosen`.
std::vector<BatchItem> itemsWithin(double tolerance_mm, const std::vector<BatchItem>& source, const std::vector<BatchItem>& chosen) {
  std::vector<BatchItem> items = source;
  for (std::size_t i = 0; i < items.size(); ++i) {
    BatchItem& item = items[i];
    if (item.status != ItemStatus::Waiting) continue;
    item.job.work = nullptr;
    item.job.settings.tolerance_mm = tolerance_mm;
    if (item.job.key() == chosen[i].key)
      item = chosen[i];
    else
      item.job.settings.quality = builder::Quality::Quick;
  }
  return items;
}

/// The items with the upper levels of their trees: as many as have at most `leaves` spheres.
std::vector<BatchItem> coarser(std::vector<BatchItem> items, std::size_t leaves) {
  for (BatchItem& item : items) {
    if (!item.hasTree()) continue;
    SphereTree& tree = item.result.tree;
    TreeFigures& figures = item.result.figures;
    int levels = kMinLevels;
    while (levels < tree.levelCount() && tree.statistics[static_cast<std::size_t>(levels)].sphere_count <= leaves) ++levels;
    if (levels >= tree.levelCount()) continue;
    tree = builder::upperLevels(tree, levels);
    figures.levels.resize(static_cast<std::size_t>(levels));
    figures.leaves = tree.statistics.back().sphere_count;
    figures.nodes = tree.nodeCount();
  }
  return items;
}

/// Largest proven and measured overhang, and the mean over the leaves of all trees.
struct Overhang {
  double bound = 0, max = 0, sum = 0;
  std::size_t leaves = 0, trees = 0;
  void add(const BatchItem& item) {
    const TreeFigures& figures = item.result.figures;
    const LevelFigures& level = figures.levels.back();
    bound = std::max(bound, figures.leafBound());
    if (level.measured) {
      max = std::max(max, level.measured->overhang.max);
      sum += level.measured->overhang.mean * static_cast<double>(figures.leaves);
    }
    leaves += figures.leaves;
    ++trees;
  }
};

class Rows {
 public:
  Rows(const std::vector<BatchItem>& chosen, ToolPaths paths, const BatchContext& context)
      : chosen_(chosen), paths_(std::move(paths)), context_(context), of_object_(chosen.size()) {
    const bool recorded = !paths_.empty();
    if (const auto all = runtimeScene(context.scene, chosen); all && !recorded) paths_ = randomContacts(*all, kSceneContacts);
    for (std::size_t i = 1; i < chosen.size(); ++i) {
      if (recorded)
        of_object_[i] = paths_;
      else if (const auto alone = runtimeScene(context.scene, chosen[0], chosen[i]))
        of_object_[i] = randomContacts(*alone, kObjectContacts);
    }
  }

  void add(const Setting& setting, const std::vector<BatchItem>& items) {
    Overhang all;
    for (const BatchItem& item : items)
      if (item.hasTree()) all.add(item);
    if (all.trees == 0) return;
    rows_.push_back(row(setting, items, nullptr, all, paths_));
    for (std::size_t i = 0; i < items.size(); ++i) {
      context_.progress.check();
      if (!items[i].hasTree()) continue;
      Overhang own;
      own.add(items[i]);
      rows_.push_back(row(setting, items, &items[i], own, of_object_[i]));
    }
  }

  std::vector<SpeedRow> take() { return std::move(rows_); }

 private:
  SpeedRow row(const Setting& setting, const std::vector<BatchItem>& items, const BatchItem* object, const Overhang& overhang,
               const ToolPaths& paths) const {
    SpeedRow out;
    if (object) out.object = object->source->name;
    if (setting.leaves > 0) out.leaves_each = setting.leaves;
    if (setting.tolerance > 0) out.tolerance_mm = setting.tolerance;
    out.chosen = setting.chosen();
    out.leaves = overhang.leaves;
    out.overhang_bound_mm = overhang.bound;
    out.overhang_max_mm = overhang.max;
    out.overhang_mean_mm = overhang.sum / static_cast<double>(overhang.leaves);
    std::optional<runtime::Scene> scene;
    // A single object is combined with the chosen tool; the tool alone has no contacts.
    if (!object)
      scene = runtimeScene(context_.scene, items);
    else if (!object->is_tool)
      scene = runtimeScene(context_.scene, chosen_[0], *object);
    if (!scene) return out;
    out.memory_bytes = scene->byteCount();
    out.cost = measureSteps(*scene, paths, true);
    return out;
  }

  const std::vector<BatchItem>& chosen_;
  ToolPaths paths_;
  const BatchContext& context_;
  std::vector<ToolPaths> of_object_;
  std::vector<SpeedRow> rows_;
};

}  // namespace

std::vector<SpeedRow> speedRows(const std::vector<BatchItem>& source, const std::vector<BatchItem>& items, ToolPaths paths,
                                const BatchContext& context) {
  Rows rows(items, std::move(paths), context);
  const auto measure = [&](const Setting& setting, const std::vector<BatchItem>& built) {
    char what[48] = "the chosen trees";
    if (setting.leaves > 0) std::snprintf(what, sizeof what, "%zu leaves", setting.leaves);
    if (setting.tolerance > 0) std::snprintf(what, sizeof what, "%.6g mm", setting.tolerance);
    context.progress.stage("chart, steps with " + std::string(what));
    rows.add(setting, built);
  };

  std::vector<BatchItem> deep = deepItems(context.scene, source);
  buildItems(deep, context, "chart, trees");
  std::size_t most = 0;
  for (const BatchItem& item : deep)
    if (item.hasTree()) most = std::max(most, item.result.figures.leaves);
  for (std::size_t leaves = kMaxBranching, below = 0; below < most && leaves <= kMaxLeaves; below = leaves, leaves *= kMaxBranching)
    measure({.leaves = leaves}, coarser(deep, leaves));

  const auto is_chosen = [](const BatchItem& a, const BatchItem& b) { return a.key == b.key; };
  for (const double tolerance : tolerancesOf(source)) {
    std::vector<BatchItem> built = itemsWithin(tolerance, source, items);
    if (std::equal(built.begin(), built.end(), items.begin(), is_chosen)) continue;  // the row of the chosen trees
    char what[48];
    std::snprintf(what, sizeof what, "chart, %.6g mm", tolerance);
    buildItems(built, context, what);
    measure({.tolerance = tolerance}, built);
  }
  measure({}, items);
  return rows.take();
}

}  // namespace spheretree::pipeline
