// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/speed_rows.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include "spheretree/runtime/scene.h"

namespace spheretree::pipeline {
namespace {

constexpr std::size_t kMinLeaves = 8, kMaxLeaves = 4096;
constexpr std::size_t kObjectContacts = 40;

/// The setting of a row: a number of leaves for each tree, a tolerance, or neither: the chosen trees.
struct Setting {
  std::size_t leaves = 0;
  double tolerance = 0;
  bool chosen() const { return leaves == 0 && tolerance == 0; }
};

std::vector<Setting> settingsFor(const formats::SceneFile& scene, const std::vector<BatchItem>& source) {
  std::vector<Setting> out;
  std::size_t largest = 0;
  std::set<double> tolerances;
  for (const BatchItem& item : source) {
    if (item.status != ItemStatus::Waiting) continue;
    largest = std::max(largest, maxLeaves(scene, item));
    if (item.job.settings.tolerance_mm > 0) tolerances.insert(item.job.settings.tolerance_mm);
  }
  for (std::size_t leaves = kMinLeaves; leaves <= std::min(largest, kMaxLeaves); leaves *= 2) out.push_back({leaves, 0});
  for (const double t : tolerances) out.push_back({0, t});
  return out;
}

/// The items as they were read, to be built for this setting. A builder other than cover keeps the leaves of its
/// levels.
std::vector<BatchItem> itemsFor(const Setting& setting, const formats::SceneFile& scene, const std::vector<BatchItem>& source) {
  std::vector<BatchItem> items = source;
  for (BatchItem& item : items) {
    if (item.status != ItemStatus::Waiting) continue;
    builder::BuildSettings& settings = item.job.settings;
    settings.quality = builder::Quality::Quick;
    settings.tolerance_mm = setting.tolerance;
    item.job.work = nullptr;  // the same tolerance everywhere: the chosen trees may be better than that
    if (setting.leaves == 0 || settings.builder != builder::BuilderKind::Cover) continue;
    limitLeaves(settings, std::min(setting.leaves, maxLeaves(scene, item)));
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
  for (const Setting& setting : settingsFor(context.scene, source)) {
    std::vector<BatchItem> built = itemsFor(setting, context.scene, source);
    char tolerance[32];
    std::snprintf(tolerance, sizeof tolerance, "%.6g mm", setting.tolerance);
    const std::string what = setting.leaves > 0 ? std::to_string(setting.leaves) + " leaves" : std::string(tolerance);
    buildItems(built, context, "chart, " + what);
    context.progress.stage("chart, steps with " + what);
    rows.add(setting, built);
  }
  rows.add({}, items);
  return rows.take();
}

}  // namespace spheretree::pipeline
