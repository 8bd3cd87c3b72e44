// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/evaluation_json.h"

#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

namespace spheretree::pipeline {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

Json pointJson(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

Vector3d pointAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) return Vector3d::Zero();
  return {found->at(0).get<double>(), found->at(1).get<double>(), found->at(2).get<double>()};
}

constexpr double kDegree = 180 / std::numbers::pi;  // [degrees/rad]

/// JSON has no infinity; the library writes it as null.
double numberAt(const Json& json, const char* key) {
  const Json& value = json.at(key);
  return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

}  // namespace

Json levelJson(const builder::LevelEvaluation& level) {
  const builder::Overhang& overhang = level.overhang;
  Json out;
  out["level"] = level.level;
  out["spheres"] = level.spheres;
  out["overhang_mm"] = {{"max", overhang.max}, {"bound", overhang.bound}, {"p99", overhang.p99}, {"mean", overhang.mean}};
  if (overhang.max > 0) out["worst_overhang_at_mm"] = pointJson(overhang.worst_point);
  out["uncovered_fraction"] = level.coverage.uncovered_fraction;
  out["max_gap_mm"] = level.coverage.max_gap;
  out["max_gap_bound_mm"] = level.coverage.max_gap_bound;
  if (level.coverage.max_gap > 0) out["worst_gap_at_mm"] = pointJson(level.coverage.worst_point);
  out["excess_volume_fraction"] = level.excess_volume_fraction;
  out["missing_volume_fraction"] = level.missing_volume_fraction;
  return out;
}

builder::LevelEvaluation levelFromJson(const Json& json) {
  builder::LevelEvaluation level;
  level.level = json.at("level").get<int>();
  level.spheres = json.at("spheres").get<std::size_t>();
  const Json& overhang = json.at("overhang_mm");
  level.overhang.max = numberAt(overhang, "max");
  level.overhang.bound = numberAt(overhang, "bound");
  level.overhang.p99 = numberAt(overhang, "p99");
  level.overhang.mean = numberAt(overhang, "mean");
  level.overhang.worst_point = pointAt(json, "worst_overhang_at_mm");
  level.coverage.uncovered_fraction = numberAt(json, "uncovered_fraction");
  level.coverage.max_gap = numberAt(json, "max_gap_mm");
  level.coverage.max_gap_bound = numberAt(json, "max_gap_bound_mm");
  level.coverage.worst_point = pointAt(json, "worst_gap_at_mm");
  level.excess_volume_fraction = numberAt(json, "excess_volume_fraction");
  level.missing_volume_fraction = numberAt(json, "missing_volume_fraction");
  return level;
}

Json skinJson(const builder::SkinEvaluation& skin) {
  Json out{
      {"triangles", skin.triangles},
      {"vertices", skin.vertices},
      {"edges", skin.edges},
      {"sharp_edges", skin.sharp_edges},
      {"flat_triangles", skin.flat_triangles},
      {"bytes", skin.bytes},
      {"tolerance_mm", skin.tolerance},
      {"mesh_distance_mm", skin.mesh_distance},
      {"crease_angle_deg", skin.crease_angle * kDegree},
      {"edge_angle_deg",
       {{"median", skin.edge_angle_median * kDegree}, {"p99", skin.edge_angle_p99 * kDegree}, {"max", skin.edge_angle_max * kDegree}}}};
  if (skin.from_mesh && skin.of_mesh) out["measured_mm"] = {{"from_mesh", *skin.from_mesh}, {"of_mesh", *skin.of_mesh}};
  return out;
}

builder::SkinEvaluation skinFromJson(const Json& json) {
  builder::SkinEvaluation skin;
  skin.triangles = json.at("triangles").get<std::size_t>();
  skin.vertices = json.at("vertices").get<std::size_t>();
  skin.edges = json.at("edges").get<std::size_t>();
  skin.sharp_edges = json.at("sharp_edges").get<std::size_t>();
  skin.flat_triangles = json.at("flat_triangles").get<std::size_t>();
  skin.bytes = json.at("bytes").get<std::size_t>();
  skin.tolerance = numberAt(json, "tolerance_mm");
  skin.mesh_distance = numberAt(json, "mesh_distance_mm");
  skin.crease_angle = numberAt(json, "crease_angle_deg") / kDegree;
  const Json& angle = json.at("edge_angle_deg");
  skin.edge_angle_median = numberAt(angle, "median") / kDegree;
  skin.edge_angle_p99 = numberAt(angle, "p99") / kDegree;
  skin.edge_angle_max = numberAt(angle, "max") / kDegree;
  if (json.contains("measured_mm")) {
    skin.from_mesh = numberAt(json.at("measured_mm"), "from_mesh");
    skin.of_mesh = numberAt(json.at("measured_mm"), "of_mesh");
  }
  return skin;
}

Json hullsJson(const builder::HullEvaluation& hulls) {
  return {{"hulls", hulls.hulls},       {"parts", hulls.parts},
          {"balls", hulls.balls},       {"overhang_mm", {{"max", hulls.overhang_max}, {"bound", hulls.overhang_bound}}},
          {"samples", hulls.samples},   {"bare_samples", hulls.bare_samples},
          {"max_gap_mm", hulls.max_gap}};
}

Json hullsJson(const Hulls& hulls) {
  if (hulls.empty()) return nullptr;
  return {
      {"hulls", hulls.count}, {"parts", hulls.parts.size()}, {"balls", hulls.balls.size()}, {"overhang_bound_mm", hulls.overhang_bound}};
}

Json hierarchyJson(const builder::HierarchyEvaluation& hierarchy) {
  return {{"leaves", hierarchy.leaves},
          {"leaves_outside_ancestor", hierarchy.leaves_outside_ancestor},
          {"leaves_outside_ancestor_cover", hierarchy.leaves_outside_ancestor_cover}};
}

builder::HierarchyEvaluation hierarchyFromJson(const Json& json) {
  return {json.at("leaves").get<std::size_t>(), json.at("leaves_outside_ancestor").get<std::size_t>(),
          json.at("leaves_outside_ancestor_cover").get<std::size_t>()};
}

Json evaluationJson(const builder::Evaluation& evaluation) {
  Json out;
  out["schema"] = "spheretree.evaluation/1";
  out["diagonal_mm"] = evaluation.diagonal;
  out["tolerance_mm"] = evaluation.tolerance;
  out["levels"] = Json::array();
  for (const builder::LevelEvaluation& level : evaluation.levels) out["levels"].push_back(levelJson(level));
  out["hierarchy"] = hierarchyJson(evaluation.hierarchy);
  if (evaluation.skin) out["skin"] = skinJson(*evaluation.skin);
  if (evaluation.hulls) out["hulls"] = hullsJson(*evaluation.hulls);
  if (evaluation.proven) {
    const double best = evaluation.proven->overhang, bound = evaluation.levels.back().overhang.bound;
    out["proven_limit"] = {{"overhang_mm", best}, {"ratio", best > 0 ? Json(bound / best) : Json()}};
  }
  if (evaluation.limits)
    out["limit_mm"] = {
        {"h_fin", evaluation.limits->h_fin}, {"h_low", evaluation.limits->h_low}, {"h_low_in_range", evaluation.limits->h_low_in_range}};
  return out;
}

}  // namespace spheretree::pipeline
