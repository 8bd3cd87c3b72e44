// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/sound_mesh.h"

#include <algorithm>

#include "spheretree/builder/build_sphere_tree.h"

namespace spheretree::pipeline {
namespace {

using Json = nlohmann::ordered_json;

/// Ranges of consecutive numbers, as [first, last].
Json runsOf(const std::vector<std::uint32_t>& sorted) {
  Json runs = Json::array();
  for (std::size_t i = 0, j = 0; i < sorted.size(); i = j) {
    while (j < sorted.size() && sorted[j] == sorted[i] + (j - i)) ++j;
    runs.push_back({sorted[i], sorted[j - 1]});
  }
  return runs;
}

}  // namespace

formats::MeshFile readMeshIn(const std::filesystem::path& path, const std::string& unit) {
  return unit.empty() ? formats::readMesh(path) : formats::readMesh(path, formats::unitInMm(unit), formats::unitInMm(unit));
}

builder::RepairKind repairKind(const std::string& option) {
  if (option == "off") return builder::RepairKind::Off;
  return option == "wrap" ? builder::RepairKind::Wrap : builder::RepairKind::Auto;
}

builder::RepairedMesh soundMesh(const TriangleMesh& mesh, const std::string& name, builder::RepairKind kind,
                                std::vector<std::string>& notes, builder::Progress& progress) {
  builder::RepairedMesh repaired = builder::repairMesh(mesh, kind, progress);
  if (!repaired.isSound()) {
    std::string message = name + ": the mesh is refused: " + repaired.result.summary();
    std::replace(message.begin(), message.end(), '\n', ' ');
    message += kind == builder::RepairKind::Off ? "--repair auto may repair it; `spheretree check` tells whether."
                                                : "No repair makes this mesh sound.";
    throw builder::BuildError(message);
  }
  for (const builder::RepairStep& step : repaired.steps) notes.push_back(step.text);
  return repaired;
}

nlohmann::ordered_json repairJson(const builder::RepairedMesh& repaired) {
  Json out;
  out["steps"] = Json::array();
  for (const builder::RepairStep& step : repaired.steps) {
    std::string key(builder::name(step.kind));
    std::replace(key.begin(), key.end(), ' ', '_');
    out["steps"].push_back({{"step", key},
                            {"count", step.count},
                            {"change_mm", step.change_mm},
                            {"removed_triangles", runsOf(step.removed)},
                            {"text", step.text}});
  }
  out["bound_mm"] = repaired.bound_mm;
  out["input_triangles"] = repaired.report.triangles;
  out["partly_removed_triangles"] = runsOf(repaired.partly);
  out["input_pieces_covered_too"] = repaired.to_cover.triangles.size();
  return out;
}

}  // namespace spheretree::pipeline
