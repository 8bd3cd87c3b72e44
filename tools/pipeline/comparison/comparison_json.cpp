// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/comparison/comparison_json.h"

#include <nlohmann/json.hpp>

#include "pipeline/builder_names.h"
#include "pipeline/evaluation_json.h"
#include "pipeline/json_file.h"

namespace spheretree::pipeline {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "spheretree.comparison/1";

void add(Json& out, const Method& method) {
  out["builder"] = name(method.builder);
  out["quality"] = builder::name(method.quality);
}

Method methodFromJson(const Json& json) {
  const std::string builder = json.at("builder").get<std::string>(), quality = json.at("quality").get<std::string>();
  const auto known = [](const std::vector<std::string>& names, const std::string& name) {
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw formats::FormatError("compare.json: '" + name + "' is no builder or quality of this version. Run spheretree compare again.");
  };
  known(namesOf(kNamedBuilders), builder);
  known(namesOf(kQualities), quality);
  return {byName(kNamedBuilders, builder), byName(kQualities, quality)};
}

Json toJson(const MeanFigures& mean) {
  Json out;
  add(out, mean.method);
  out["processor_seconds"] = mean.figures.processor_seconds;
  out["seconds"] = mean.figures.seconds;
  out["overhang_percent"] = mean.figures.overhang_percent;
  out["p99_percent"] = mean.figures.p99_percent;
  out["excess_percent"] = mean.figures.excess_percent;
  return out;
}

}  // namespace

Json toJson(const MeshFigures& mesh) {
  Json others = Json::array();
  for (const OtherFigures& other : mesh.others)
    others.push_back({{"name", other.name},
                      {"file", other.file.string()},
                      {"format", other.format},
                      {"processor_seconds", other.seconds},
                      {"level", levelJson(other.level)}});
  return {{"name", mesh.name},
          {"file", mesh.file.string()},
          {"triangles", mesh.triangles},
          {"diagonal_mm", mesh.diagonal_mm},
          {"area_mm2", mesh.area_mm2},
          {"volume_mm3", mesh.volume_mm3},
          {"limit_mm",
           {{"leaves", mesh.leaves},
            {"h_fin", mesh.limits.h_fin},
            {"h_low", mesh.limits.h_low},
            {"h_low_in_range", mesh.limits.h_low_in_range}}},
          {"unit_mm", mesh.unit_mm},
          {"other_spheres", others}};
}

MeshFigures meshFiguresFromJson(const Json& json) {
  MeshFigures mesh;
  mesh.name = json.at("name").get<std::string>();
  mesh.file = json.at("file").get<std::string>();
  mesh.unit_mm = json.value("unit_mm", 1.0);
  mesh.triangles = json.at("triangles").get<std::size_t>();
  mesh.diagonal_mm = json.at("diagonal_mm").get<double>();
  mesh.area_mm2 = json.at("area_mm2").get<double>();
  mesh.volume_mm3 = json.at("volume_mm3").get<double>();
  const Json& limit = json.at("limit_mm");
  mesh.leaves = limit.at("leaves").get<double>();
  mesh.limits = {limit.at("h_fin").get<double>(), limit.at("h_low").get<double>(), limit.at("h_low_in_range").get<bool>()};
  for (const Json& other : json.value("other_spheres", Json::array()))
    mesh.others.push_back({other.at("name").get<std::string>(), other.at("file").get<std::string>(), other.at("format").get<std::string>(),
                           levelFromJson(other.at("level")), other.value("processor_seconds", 0.0)});
  return mesh;
}

Json toJson(const Run& run) {
  Json out{{"mesh", run.mesh}};
  add(out, run.method);
  if (!run.isBuilt()) {
    out["status"] = "failed";
    out["error"] = run.error;
    return out;
  }
  out["status"] = "built";
  out["tree"] = run.tree.string();
  out["seconds"] = run.seconds;
  out["processor_seconds"] = run.processor_seconds;
  out["nodes"] = run.nodes;
  out["levels"] = Json::array();
  for (const builder::LevelEvaluation& level : run.levels) out["levels"].push_back(levelJson(level));
  out["hierarchy"] = hierarchyJson(run.hierarchy);
  return out;
}

Run runFromJson(const Json& json) {
  Run run;
  run.mesh = json.at("mesh").get<std::string>();
  run.method = methodFromJson(json);
  if (json.at("status") != "built") {
    run.error = json.at("error").get<std::string>();
    if (run.error.empty()) run.error = "unknown";
    return run;
  }
  run.tree = json.at("tree").get<std::string>();
  run.seconds = json.at("seconds").get<double>();
  run.processor_seconds = json.at("processor_seconds").get<double>();
  run.nodes = json.at("nodes").get<std::size_t>();
  for (const Json& level : json.at("levels")) run.levels.push_back(levelFromJson(level));
  run.hierarchy = hierarchyFromJson(json.at("hierarchy"));
  return run;
}

Json toJson(const Sensitivity& sensitivity) {
  Json out{{"mesh", sensitivity.mesh}};
  add(out, sensitivity.method);
  if (!sensitivity.error.empty()) {
    out["error"] = sensitivity.error;
    return out;
  }
  out["rows"] = Json::array();
  for (const builder::SensitivityRow& row : sensitivity.rows)
    out["rows"].push_back(
        {{"change", row.change}, {"cases", row.cases}, {"largest_change", row.largest_change}, {"same_spheres", row.same_spheres}});
  return out;
}

Sensitivity sensitivityFromJson(const Json& json) {
  Sensitivity out;
  out.mesh = json.at("mesh").get<std::string>();
  out.method = methodFromJson(json);
  out.error = json.value("error", "");
  for (const Json& row : json.value("rows", Json::array()))
    out.rows.push_back({row.at("change").get<std::string>(), row.at("cases").get<int>(), row.at("largest_change").get<double>(),
                        row.at("same_spheres").get<bool>()});
  return out;
}

Json toJson(const Comparison& comparison) {
  Json out{{"schema", kSchema},
           {"generator", comparison.generator},
           {"machine", {{"processor", comparison.processor}, {"threads", comparison.threads}}},
           {"settings", {{"levels", comparison.levels}, {"branching", comparison.branching}, {"seed", comparison.seed}}},
           {"meshes", Json::array()},
           {"runs", Json::array()}};
  for (const MeshFigures& mesh : comparison.meshes) out["meshes"].push_back(toJson(mesh));
  for (const Run& run : comparison.runs) out["runs"].push_back(toJson(run));
  if (comparison.sensitivity) {
    out["stability"] = Json::array();
    for (const Sensitivity& s : *comparison.sensitivity) out["stability"].push_back(toJson(s));
  }
  out["geometric_means"] = Json::array();
  for (const MeanFigures& mean : comparison.means) out["geometric_means"].push_back(toJson(mean));
  return out;
}

Comparison readComparison(const std::filesystem::path& path) {
  return readJsonAs(path, kSchema, [](const Json& json) {
    Comparison out;
    out.generator = json.at("generator").get<std::string>();
    out.processor = json.at("machine").at("processor").get<std::string>();
    out.threads = json.at("machine").at("threads").get<int>();
    const Json& settings = json.at("settings");
    out.levels = settings.at("levels").get<int>();
    out.branching = settings.at("branching").get<int>();
    out.seed = settings.at("seed").get<std::uint64_t>();
    for (const Json& mesh : json.at("meshes")) out.meshes.push_back(meshFiguresFromJson(mesh));
    for (const Json& run : json.at("runs")) out.runs.push_back(runFromJson(run));
    if (json.contains("stability")) {
      out.sensitivity.emplace();
      for (const Json& s : json.at("stability")) out.sensitivity->push_back(sensitivityFromJson(s));
    }
    out.means = geometricMeans(out);
    return out;
  });
}

}  // namespace spheretree::pipeline
