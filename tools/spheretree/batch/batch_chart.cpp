// SPDX-License-Identifier: GPL-3.0-or-later
#include "batch/batch_chart.h"

#include <algorithm>
#include <set>

namespace spheretree::tool {
namespace {

constexpr std::size_t kLeastLeaves = 8, kMostLeaves = 4096;
constexpr std::size_t kObjectTouches = 40;

/// What a row was built to: a number of leaves each, a tolerance, or neither: what was chosen.
struct Setting {
  std::size_t leaves = 0;
  double tolerance = 0;
  bool chosen() const { return leaves == 0 && tolerance == 0; }
};

std::vector<Setting> settingsFor(const formats::SceneFile& scene, const std::vector<Item>& source) {
  std::vector<Setting> out;
  std::size_t most = 0;
  std::set<double> tolerances;
  for (const Item& item : source) {
    if (item.status != ItemStatus::Waiting) continue;
    most = std::max(most, mostLeaves(scene, item));
    if (item.job.settings.tolerance_mm > 0) tolerances.insert(item.job.settings.tolerance_mm);
  }
  for (std::size_t leaves = kLeastLeaves; leaves <= std::min(most, kMostLeaves); leaves *= 2) out.push_back({leaves, 0});
  for (const double t : tolerances) out.push_back({0, t});
  return out;
}

/// The items as they were read, to be built for this setting. A builder other than cover keeps the leaves of its levels.
std::vector<Item> itemsFor(const Setting& setting, const formats::SceneFile& scene, const std::vector<Item>& source) {
  std::vector<Item> items = source;
  for (Item& item : items) {
    if (item.status != ItemStatus::Waiting) continue;
    builder::BuildSettings& settings = item.job.settings;
    settings.quality = builder::Quality::Quick;
    settings.tolerance_mm = setting.tolerance;
    item.job.site = nullptr;  // the same accuracy everywhere: what was chosen may do better than that
    if (setting.leaves == 0 || settings.builder != builder::BuilderKind::Cover) continue;
    limitLeaves(settings, std::min(setting.leaves, mostLeaves(scene, item)));
  }
  return items;
}

/// Largest proven and measured overhang, and the mean over the leaves of all.
struct Overhang {
  double bound = 0, max = 0, sum = 0;
  std::size_t leaves = 0, trees = 0;
  void add(const Item& item) {
    const Json& record = item.result.record;
    const Json& overhang = record.at("levels").back().at("overhang_mm");
    const auto n = record.at("leaves").get<std::size_t>();
    const auto number = [&](const char* key) {
      return overhang.contains(key) && overhang.at(key).is_number() ? overhang.at(key).get<double>() : 0.0;
    };
    bound = std::max(bound, number("bound"));
    max = std::max(max, number("max"));
    sum += number("mean") * static_cast<double>(n);
    leaves += n;
    ++trees;
  }
};

class Rows {
 public:
  Rows(const formats::SceneFile& scene, const std::vector<Item>& chosen, Hands hands, const Workshop& workshop)
      : scene_(scene), chosen_(chosen), hands_(std::move(hands)), workshop_(workshop), of_object_(chosen.size()) {
    const bool recorded = !hands_.empty();
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (chosen[i].is_tool) {
        if (const auto all = runtimeScene(scene, chosen); all && !recorded) hands_ = randomTouches(*all, kTouches);
      } else if (recorded) {
        of_object_[i] = hands_;
      } else if (const auto alone = runtimeScene(scene, chosen, &chosen[i]); alone && chosen[i].hasTree()) {
        of_object_[i] = randomTouches(*alone, kObjectTouches);
      }
    }
  }

  void add(const Setting& setting, const std::vector<Item>& items) {
    Overhang all;
    for (const Item& item : items)
      if (item.hasTree()) all.add(item);
    if (all.trees == 0) return;
    rows_.push_back(row(setting, items, nullptr, all, hands_));
    for (std::size_t i = 0; i < items.size(); ++i) {
      workshop_.progress.check();
      if (!items[i].hasTree()) continue;
      Overhang own;
      own.add(items[i]);
      rows_.push_back(row(setting, items, &items[i], own, of_object_[i]));
    }
  }

  Json take() { return std::move(rows_); }

 private:
  Json row(const Setting& setting, const std::vector<Item>& items, const Item* object, const Overhang& overhang, const Hands& hands) {
    Json out{{"object", object ? Json(object->source->name) : Json(nullptr)},
             {"leaves_each", setting.leaves > 0 ? Json(setting.leaves) : Json(nullptr)},
             {"tolerance_mm", setting.tolerance > 0 ? Json(setting.tolerance) : Json(nullptr)},
             {"chosen", setting.chosen()},
             {"leaves", overhang.leaves},
             {"overhang_bound_mm", overhang.bound},
             {"overhang_max_mm", overhang.max},
             {"overhang_mean_mm", overhang.sum / static_cast<double>(overhang.leaves)}};
    std::optional<runtime::Scene> scene;
    // An object alone meets the tool that was chosen; the tool alone meets nothing.
    if (!object)
      scene = runtimeScene(scene_, items);
    else if (!object->is_tool)
      scene = runtimeScene(scene_, {chosen_[0], *object});
    const std::optional<StepCost> cost = scene ? measureSteps(*scene, hands, true) : std::nullopt;
    out["memory_bytes"] = scene ? Json(memoryOf(*scene)) : Json(nullptr);
    out["steps"] = cost ? cost->steps : 0;
    out["pairs_median"] = cost ? Json(cost->pairs_median) : Json(nullptr);
    out["pairs_p99"] = cost ? Json(cost->pairs_p99) : Json(nullptr);
    out["model_us_p99"] = cost ? Json(cost->model_us_p99) : Json(nullptr);
    out["step_us_median"] = cost ? Json(cost->time_us_median) : Json(nullptr);
    out["step_us_p99"] = cost ? Json(cost->time_us_p99) : Json(nullptr);
    return out;
  }

  const formats::SceneFile& scene_;
  const std::vector<Item>& chosen_;
  Hands hands_;
  const Workshop& workshop_;
  std::vector<Hands> of_object_;
  Json rows_ = Json::array();
};

}  // namespace

Json paretoOf(const formats::SceneFile& scene, const std::vector<Item>& source, const std::vector<Item>& items, WorkSite* site, Hands hands,
              const Workshop& workshop) {
  Rows rows(scene, items, std::move(hands), workshop);
  for (const Setting& setting : settingsFor(scene, source)) {
    std::vector<Item> built = itemsFor(setting, scene, source);
    const std::string what = setting.leaves > 0 ? std::to_string(setting.leaves) + " leaves" : Json(setting.tolerance).dump() + " mm";
    buildItems(built, site, workshop, "chart, " + what);
    workshop.progress.stage("chart, steps with " + what);
    rows.add(setting, built);
  }
  rows.add({}, items);
  return rows.take();
}

}  // namespace spheretree::tool
