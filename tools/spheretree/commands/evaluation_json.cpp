// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/evaluation_json.h"

namespace spheretree::tool {

using Json = nlohmann::ordered_json;

nlohmann::ordered_json evaluationJson(const builder::Evaluation& evaluation) {
  const auto point = [](const Eigen::Vector3d& p) { return Json{p.x(), p.y(), p.z()}; };
  nlohmann::ordered_json out;
  out["schema"] = "spheretree.evaluation/1";
  out["diagonal_mm"] = evaluation.diagonal;
  out["tolerance_mm"] = evaluation.tolerance;
  out["levels"] = Json::array();
  for (const builder::LevelEvaluation& level : evaluation.levels) {
    const builder::Overhang& overhang = level.overhang;
    Json line;
    line["level"] = level.level;
    line["spheres"] = level.spheres;
    line["overhang_mm"] = {{"max", overhang.max}, {"bound", overhang.bound}, {"p99", overhang.p99}, {"mean", overhang.mean}};
    if (overhang.max > 0) line["worst_overhang_at_mm"] = point(overhang.worst_point);
    line["uncovered_fraction"] = level.coverage.uncovered_fraction;
    line["max_gap_mm"] = level.coverage.max_gap;
    line["max_gap_bound_mm"] = level.coverage.max_gap_bound;
    if (level.coverage.max_gap > 0) line["worst_gap_at_mm"] = point(level.coverage.worst_point);
    line["excess_volume_fraction"] = level.excess_volume_fraction;
    line["missing_volume_fraction"] = level.missing_volume_fraction;
    out["levels"].push_back(line);
  }
  const builder::HierarchyEvaluation& hierarchy = evaluation.hierarchy;
  out["hierarchy"] = {{"leaves", hierarchy.leaves},
                      {"leaves_outside_ancestor", hierarchy.leaves_outside_ancestor},
                      {"leaves_outside_ancestor_cover", hierarchy.leaves_outside_ancestor_cover}};
  if (evaluation.limits)
    out["limit_mm"] = {
        {"h_fin", evaluation.limits->h_fin}, {"h_low", evaluation.limits->h_low}, {"h_low_in_range", evaluation.limits->h_low_in_range}};
  return out;
}

}  // namespace spheretree::tool
