// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/tree_figures.h"

#include <algorithm>

#include "measure/evaluate_skin.h"
#include "pipeline/evaluation_json.h"
#include "pipeline/json_file.h"

namespace spheretree::pipeline {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const LevelFigures& level) {
  if (level.measured) return levelJson(*level.measured);
  return {{"level", level.level}, {"spheres", level.spheres}, {"overhang_mm", {{"bound", orNull(level.overhang_bound_mm)}}}};
}

LevelFigures levelFiguresFromJson(const Json& json) {
  LevelFigures level;
  level.level = json.at("level").get<int>();
  level.spheres = json.at("spheres").get<std::size_t>();
  level.overhang_bound_mm = optionalAt<double>(json.at("overhang_mm"), "bound");
  if (json.at("overhang_mm").contains("max")) level.measured = levelFromJson(json);
  return level;
}

Json toJson(const RepairFigures& step) {
  return {{"step", step.step},
          {"count", step.count},
          {"change_mm", step.change_mm},
          {"removed_triangles", step.removed_triangles},
          {"text", step.text}};
}

}  // namespace

double TreeFigures::repairChange() const {
  double change = 0;
  for (const RepairFigures& step : repair) change = std::max(change, step.change_mm);
  return change;
}

std::size_t TreeFigures::removedTriangles() const {
  std::size_t removed = 0;
  for (const RepairFigures& step : repair) removed += step.removed_triangles;
  return removed;
}

bool TreeFigures::isChangeLarge() const {
  const double change = repairChange();
  return change > diagonal_mm / 100 || (tolerance_mm && change > *tolerance_mm);
}

bool TreeFigures::isLossLarge() const { return 10 * removedTriangles() > input_triangles && input_triangles > 0; }

TreeFigures figuresOf(const SphereTree& tree) {
  TreeFigures figures;
  figures.triangles = tree.provenance.triangle_count;
  figures.leaves = tree.statistics.back().sphere_count;
  figures.nodes = tree.nodeCount();
  figures.diagonal_mm = tree.provenance.diagonal_mm;
  figures.certified = tree.statistics.back().overhang_bound != kUnproven;
  for (std::size_t level = 0; level < tree.statistics.size(); ++level) {
    const LevelStatistics& s = tree.statistics[level];
    const bool is_proven = s.overhang_bound != kUnproven;
    figures.levels.push_back(
        {static_cast<int>(level), s.sphere_count, is_proven ? std::optional<double>(s.overhang_bound) : std::nullopt, std::nullopt});
  }
  if (!tree.skin.empty()) figures.skin = builder::skinFigures(tree.skin);
  return figures;
}

Json toJson(const TreeFigures& figures) {
  Json out{{"triangles", figures.triangles},
           {"leaves", figures.leaves},
           {"nodes", figures.nodes},
           {"diagonal_mm", figures.diagonal_mm},
           {"tolerance_mm", orNull(figures.tolerance_mm)},
           {"tolerance_met", orNull(figures.tolerance_met)},
           {"certified", figures.certified},
           {"input_triangles", figures.input_triangles},
           {"repair", Json::array()},
           {"repair_change_mm", figures.repairChange()},
           {"repair_large", figures.isRepairLarge()},
           {"notes", figures.notes},
           {"levels", Json::array()}};
  for (const RepairFigures& step : figures.repair) out["repair"].push_back(toJson(step));
  for (const LevelFigures& level : figures.levels) out["levels"].push_back(toJson(level));
  if (figures.ratio) {
    out["tolerance_ratio"] = figures.ratio->ratio;
    if (figures.ratio->min_met_mm) out["min_met_mm"] = *figures.ratio->min_met_mm;
  }
  if (figures.min_tolerance_mm) out["min_tolerance_mm"] = *figures.min_tolerance_mm;
  if (figures.skin) out["skin"] = skinJson(*figures.skin);
  if (figures.work) {
    out["work"] = Json::array();
    for (const WorkFigures& region : *figures.work)
      out["work"].push_back({{"name", region.name},
                             {"tolerance_mm", region.tolerance_mm},
                             {"triangles", region.triangles},
                             {"overhang_bound_mm", region.overhang_bound_mm}});
  }
  return out;
}

TreeFigures treeFiguresFromJson(const Json& json) {
  TreeFigures figures;
  figures.triangles = json.at("triangles").get<std::size_t>();
  figures.leaves = json.at("leaves").get<std::size_t>();
  figures.nodes = json.at("nodes").get<std::size_t>();
  figures.diagonal_mm = json.at("diagonal_mm").get<double>();
  figures.tolerance_mm = optionalAt<double>(json, "tolerance_mm");
  figures.tolerance_met = optionalAt<bool>(json, "tolerance_met");
  figures.certified = json.at("certified").get<bool>();
  figures.input_triangles = json.at("input_triangles").get<std::size_t>();
  for (const Json& step : json.at("repair"))
    figures.repair.push_back({step.at("step").get<std::string>(), step.at("text").get<std::string>(), step.at("count").get<std::size_t>(),
                              step.at("removed_triangles").get<std::size_t>(), step.at("change_mm").get<double>()});
  figures.notes = json.at("notes").get<std::vector<std::string>>();
  for (const Json& level : json.at("levels")) figures.levels.push_back(levelFiguresFromJson(level));
  if (const auto ratio = optionalAt<double>(json, "tolerance_ratio"))
    figures.ratio = ToleranceRatio{*ratio, optionalAt<double>(json, "min_met_mm")};
  figures.min_tolerance_mm = optionalAt<double>(json, "min_tolerance_mm");
  if (json.contains("skin")) figures.skin = skinFromJson(json.at("skin"));
  if (json.contains("work")) {
    figures.work.emplace();
    for (const Json& region : json.at("work"))
      figures.work->push_back({region.at("name").get<std::string>(), region.at("tolerance_mm").get<double>(),
                               region.at("triangles").get<std::size_t>(), region.at("overhang_bound_mm").get<double>()});
  }
  return figures;
}

}  // namespace spheretree::pipeline
