// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree check: what is wrong with a mesh, where, and what a build would do about it. Kinds of defects: docs/mesh_input.md
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "command.h"
#include "sound_mesh.h"
#include "spheretree/formats/mesh_file.h"

namespace spheretree::tool {
namespace {

using Json = nlohmann::ordered_json;

struct CheckOptions {
  std::filesystem::path input;
  std::string parts = "merge";
  double unit_mm = 1;
  bool json = false;
};

const char* buildOf(const builder::RepairedMesh& repaired) {
  return !repaired.isSound() ? "refuse" : repaired.steps.empty() ? "accept" : "fix";
}

Json pointJson(const Eigen::Vector3d& p) {
  Json point = Json::array();
  for (const double x : p) point.push_back(std::isfinite(x) ? Json(x) : Json(nullptr));
  return point;
}

Json placeJson(const builder::Place& place) {
  return {{"triangles", place.triangles}, {"vertices", place.vertices}, {"at_mm", pointJson(place.point)}};
}

std::string partOf(const TriangleMesh& mesh, std::uint32_t triangle) {
  return mesh.part.empty() ? std::string() : mesh.part_names[mesh.part[triangle]];
}

Json toJson(const formats::MeshFile& file, const TriangleMesh& mesh, const builder::RepairedMesh& repaired) {
  const builder::MeshReport& report = repaired.report;
  Json out;
  out["schema"] = "spheretree.check/1";
  out["format"] = file.format;
  out["unit_mm"] = file.unit_mm;
  out["clean"] = report.clean();
  out["build"] = buildOf(repaired);
  out["repair"] = repairJson(repaired);
  out["triangles"] = report.triangles;
  out["vertices"] = report.vertices;
  out["box_mm"] = {{"low", pointJson(report.low)}, {"high", pointJson(report.high)}};
  out["area_mm2"] = report.area;
  out["volume_mm3"] = report.volume;
  out["parts"] = file.mesh.part_names;
  out["defects"] = Json::array();
  for (const builder::Defect& defect : report.defects) {
    std::string key(name(defect.kind));
    for (char& c : key)
      if (c == ' ' || c == '-') c = '_';
    Json line;
    line["kind"] = key;
    line["count"] = defect.count;
    if (defect.is_lower_bound) line["more"] = true;
    line["first"] = Json::array();
    for (const builder::Place& place : defect.first) line["first"].push_back(placeJson(place));
    out["defects"].push_back(std::move(line));
  }
  out["holes"] = Json::array();
  for (const builder::Hole& hole : report.holes)
    out["holes"].push_back({{"edges", hole.edges}, {"length_mm", hole.length}, {"first", placeJson(hole.first)}});
  out["components"] = Json::array();
  for (const builder::Component& c : report.components)
    out["components"].push_back({{"triangles", c.triangles},
                                 {"first_triangle", c.first_triangle},
                                 {"part", partOf(mesh, c.first_triangle)},
                                 {"volume_mm3", c.volume},
                                 {"inside_out", c.inside_out},
                                 {"buried", c.buried},
                                 {"cavity", c.cavity}});
  out["not_checked"] = report.not_checked;
  out["notes"] = file.notes;
  return out;
}

void printText(const CheckOptions& options, const formats::MeshFile& file, const TriangleMesh& mesh,
               const builder::RepairedMesh& repaired) {
  const builder::MeshReport& report = repaired.report;
  const Eigen::Vector3d size = report.high - report.low;
  std::printf("%s: %s, %zu triangles, %zu vertices", options.input.c_str(), file.format.c_str(), report.triangles, report.vertices);
  if (!report.components.empty()) std::printf(", %zu component%s", report.components.size(), report.components.size() == 1 ? "" : "s");
  std::printf("\nbox %.6g x %.6g x %.6g mm, area %.6g mm2, volume %.6g mm3\n", size.x(), size.y(), size.z(), report.area, report.volume);
  for (const std::string& note : file.notes) std::printf("note: %s\n", note.c_str());
  for (const builder::Component& c : report.components) {
    if (!c.buried && !c.cavity) continue;
    const std::string part = partOf(mesh, c.first_triangle);
    std::printf("note: the component of %zu triangles from triangle %u on%s %s\n", c.triangles, c.first_triangle,
                part.empty() ? "" : (" (part \"" + part + "\")").c_str(),
                c.buried ? "lies wholly within solid matter: a build leaves it out." : "is a cavity.");
  }
  std::printf("%s", report.summary().c_str());
  if (report.clean())
    std::printf("no defects: a build takes this mesh.\n");
  else
    std::printf(repaired.isSound() ? "a build repairs this mesh, and says so:\n" : "a build refuses this mesh.\n");
  if (!report.clean())
    for (const builder::RepairStep& step : repaired.steps) std::printf("  %s\n", step.text.c_str());
}

int runCheck(const CheckOptions& options, builder::Progress& progress) {
  progress.stage("read");
  formats::MeshFile file = formats::readMesh(options.input, options.unit_mm);
  progress.check();
  progress.stage("check");
  const TriangleMesh mesh = options.parts == "merge" ? file.mesh : formats::selectPart(file.mesh, options.parts);
  const builder::RepairedMesh repaired = builder::repairMesh(mesh, builder::RepairKind::Auto, progress);
  progress.check();
  if (options.json)  // a part's name may be no UTF-8
    std::cout << toJson(file, mesh, repaired).dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
  else
    printText(options, file, mesh, repaired);
  return repaired.report.clean() ? kExitOk : kExitRefused;
}

}  // namespace

void addCheckCommand(Program& program) {
  const auto options = std::make_shared<CheckOptions>();
  CLI::App* app =
      addVerb(program, "check", "Tell what is wrong with a mesh, where, and what a build would do about it; exit code 4 if anything is",
              "spheretree check tooth.obj --json", [options](builder::Progress& progress) { return runCheck(*options, progress); });
  app->add_option("INPUT", options->input, "Mesh: .obj, .stl, .ply, .off, .gltf or .glb")->required()->type_name("FILE");
  app->add_flag("--json", options->json, "Print JSON on stdout, schema spheretree.check/1");
  app->add_option("--unit", options->unit_mm, "Unit of a mesh without one (not glTF): mm, cm, m or in; default mm")
      ->type_name("UNIT")
      ->transform(CLI::CheckedTransformer(std::map<std::string, double>{{"mm", 1}, {"cm", 10}, {"m", 1000}, {"in", 25.4}}).description(""));
  app->add_option("--parts", options->parts, "merge: all parts as one object; or the name of one part; default merge")->type_name("NAME");
}

}  // namespace spheretree::tool
