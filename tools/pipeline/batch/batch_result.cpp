// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/batch_result.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "pipeline/json_file.h"

namespace spheretree::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "spheretree.batch/1";

struct StatusName {
  ItemStatus status;
  const char* name;
};
constexpr std::array<StatusName, 3> kStatusNames{
    {{ItemStatus::Built, "built"}, {ItemStatus::Cached, "cached"}, {ItemStatus::Failed, "failed"}}};

const char* nameOf(ItemStatus status) {
  for (const StatusName& s : kStatusNames)
    if (s.status == status) return s.name;
  return "skipped";
}

ItemStatus statusByName(const std::string& name) {
  for (const StatusName& s : kStatusNames)
    if (s.name == name) return s.status;
  return ItemStatus::Skipped;
}

Json toJson(const ObjectResult& object) {
  Json out{{"name", object.name}, {"role", object.is_tool ? "tool" : "object"}, {"status", nameOf(object.status)}};
  if (!object.hasTree()) {
    out["error"] = object.error;
    return out;
  }
  out["seconds"] = object.seconds;
  out.update(toJson(object.figures));
  out["saved_leaves"] = object.saved;
  out["tree"] = object.tree.string();
  out["bytes"] = object.bytes;
  return out;
}

ObjectResult objectFromJson(const Json& json) {
  ObjectResult object;
  object.name = json.at("name").get<std::string>();
  object.is_tool = json.at("role") == "tool";
  object.status = statusByName(json.at("status").get<std::string>());
  if (!object.hasTree()) {
    object.error = json.value("error", "");
    return object;
  }
  object.seconds = json.at("seconds").get<double>();
  object.figures = treeFiguresFromJson(json);
  object.saved = json.at("saved_leaves").get<std::size_t>();
  object.tree = json.at("tree").get<std::string>();
  object.bytes = json.at("bytes").get<std::size_t>();
  return object;
}

Json toJson(const BudgetResult& b) {
  Json out{{"of", b.budget.is_time ? "us" : "leaves"}, {"amount", b.budget.amount}, {"spent", b.spent}, {"met", b.met}};
  if (b.worst_ratio) out["worst_ratio"] = *b.worst_ratio;
  out["common_ratio"] = b.common_ratio;
  if (b.budget.is_time) out["hands"] = b.has_recorded_paths ? "recorded" : "random touches";
  out["rounds"] = Json::array();
  for (const BudgetRound& round : b.rounds) {
    Json line{{"trees", round.is_final ? "final" : "quick"}, {"leaves", round.leaves}};
    if (round.worst_ratio) line["worst_ratio"] = *round.worst_ratio;
    if (round.model_us) line["model_us"] = *round.model_us;
    out["rounds"].push_back(std::move(line));
  }
  return out;
}

BudgetResult budgetFromJson(const Json& json) {
  BudgetResult b;
  b.budget = {json.at("amount").get<double>(), json.at("of") == "us"};
  b.spent = json.at("spent").get<double>();
  b.met = json.at("met").get<bool>();
  b.worst_ratio = optionalAt<double>(json, "worst_ratio");
  b.common_ratio = json.at("common_ratio").get<double>();
  b.has_recorded_paths = json.value("hands", "") == "recorded";
  for (const Json& line : json.at("rounds"))
    b.rounds.push_back({line.at("trees") == "final", line.at("leaves").get<std::size_t>(), optionalAt<double>(line, "worst_ratio"),
                        optionalAt<double>(line, "model_us")});
  return b;
}

Json toJson(const SpeedRow& row) {
  const auto cost = [&](double StepCost::*field) { return row.cost ? Json((*row.cost).*field) : Json(nullptr); };
  return {{"object", orNull(row.object)},
          {"leaves_each", orNull(row.leaves_each)},
          {"tolerance_mm", orNull(row.tolerance_mm)},
          {"chosen", row.chosen},
          {"leaves", row.leaves},
          {"overhang_bound_mm", row.overhang_bound_mm},
          {"overhang_max_mm", row.overhang_max_mm},
          {"overhang_mean_mm", row.overhang_mean_mm},
          {"memory_bytes", orNull(row.memory_bytes)},
          {"steps", row.cost ? row.cost->steps : 0},
          {"pairs_median", cost(&StepCost::pairs_median)},
          {"pairs_p99", cost(&StepCost::pairs_p99)},
          {"model_us_p99", cost(&StepCost::model_us_p99)},
          {"step_us_median", cost(&StepCost::time_us_median)},
          {"step_us_p99", cost(&StepCost::time_us_p99)}};
}

SpeedRow speedRowFromJson(const Json& json) {
  SpeedRow row;
  row.object = optionalAt<std::string>(json, "object");
  row.leaves_each = optionalAt<std::size_t>(json, "leaves_each");
  row.tolerance_mm = optionalAt<double>(json, "tolerance_mm");
  row.chosen = json.at("chosen").get<bool>();
  row.leaves = json.at("leaves").get<std::size_t>();
  row.overhang_bound_mm = json.at("overhang_bound_mm").get<double>();
  row.overhang_max_mm = json.at("overhang_max_mm").get<double>();
  row.overhang_mean_mm = json.at("overhang_mean_mm").get<double>();
  row.memory_bytes = optionalAt<std::size_t>(json, "memory_bytes");
  if (json.at("steps").get<std::size_t>() > 0)
    row.cost = StepCost{.steps = json.at("steps").get<std::size_t>(),
                        .pairs_median = json.at("pairs_median").get<double>(),
                        .pairs_p99 = json.at("pairs_p99").get<double>(),
                        .model_us_p99 = json.at("model_us_p99").get<double>(),
                        .time_us_median = json.at("step_us_median").get<double>(),
                        .time_us_p99 = json.at("step_us_p99").get<double>()};
  return row;
}

}  // namespace

BatchTotals totalsOf(const BatchResult& result) {
  BatchTotals totals;
  for (const ObjectResult& object : result.objects) {
    totals.built += object.status == ItemStatus::Built;
    totals.cached += object.status == ItemStatus::Cached;
    totals.failed += object.status == ItemStatus::Failed;
    totals.skipped += object.status == ItemStatus::Skipped;
    if (!object.hasTree()) continue;
    totals.triangles += object.figures.triangles;
    totals.leaves += object.figures.leaves;
    totals.saved += object.saved;
    totals.nodes += object.figures.nodes;
    totals.bytes += object.bytes;
    totals.overhang_bound_mm = std::max(totals.overhang_bound_mm, object.figures.leafBound());
  }
  return totals;
}

Json toJson(const BatchResult& result) {
  const BatchTotals totals = totalsOf(result);
  Json out{{"schema", kSchema},
           {"generator", result.generator},
           {"scene", result.scene.string()},
           {"tool_distance_mm", result.tool_distance_mm},
           {"objects", Json::array()},
           {"totals",
            {{"objects", result.objects.size()},
             {"built", totals.built},
             {"cached", totals.cached},
             {"failed", totals.failed},
             {"triangles", totals.triangles},
             {"leaves", totals.leaves},
             {"saved_leaves", totals.saved},
             {"nodes", totals.nodes},
             {"bytes", totals.bytes},
             {"overhang_bound_mm", totals.overhang_bound_mm},
             {"seconds", result.seconds}}}};
  for (const ObjectResult& object : result.objects) out["objects"].push_back(toJson(object));
  if (result.budget) out["budget"] = toJson(*result.budget);
  if (result.speed) {
    out["pareto"] = Json::array();
    for (const SpeedRow& row : *result.speed) out["pareto"].push_back(toJson(row));
  }
  return out;
}

BatchResult readBatchResult(const std::filesystem::path& path) {
  return readJsonAs(path, kSchema, [](const Json& json) {
    BatchResult result;
    result.generator = json.at("generator").get<std::string>();
    result.scene = json.at("scene").get<std::string>();
    result.tool_distance_mm = json.at("tool_distance_mm").get<double>();
    for (const Json& object : json.at("objects")) result.objects.push_back(objectFromJson(object));
    if (json.contains("budget")) result.budget = budgetFromJson(json.at("budget"));
    if (json.contains("pareto")) {
      result.speed.emplace();
      for (const Json& row : json.at("pareto")) result.speed->push_back(speedRowFromJson(row));
    }
    result.seconds = json.at("totals").at("seconds").get<double>();
    return result;
  });
}

}  // namespace spheretree::pipeline
