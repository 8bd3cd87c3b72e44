// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree check: the defects of a mesh, their places, and what a build would do about them. Kinds of defects:
// docs/mesh_input.md
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "input/tree_input.h"
#include "json_text.h"
#include "options/command.h"
#include "options/common_options.h"
#include "pipeline/part_choice.h"
#include "pipeline/sound_mesh.h"
#include "run_files.h"
#include "spheretree/builder/mesh_checks.h"
#include "spheretree/builder/mesh_survey.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/marked_glb.h"
#include "spheretree/formats/mesh_file.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

using Json = nlohmann::ordered_json;

struct CheckOptions {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path output;
  std::string parts = "merge", unit, fail_on = "defects";
  bool json = false, list_parts = false;
};

/// One line of --list-parts: a named part, or a connected component that is none.
struct PartLine {
  std::string name;                        // as --parts accepts it
  std::optional<std::uint32_t> component;  // that has the same triangles
  std::size_t triangles;
  double volume_mm3;
  Eigen::Vector3d low_mm, high_mm;  // of its box
  const char* state;                // of this part alone: sound, inside out, defective
};

const char* buildOf(const builder::RepairedMesh& repaired) {
  return !repaired.isSound() ? "refuse" : repaired.steps.empty() ? "accept" : "fix";
}

/// The component that has exactly the triangles of a part; empty for parts of several components, or of a share of one.
std::vector<std::optional<std::uint32_t>> componentsOfParts(const TriangleMesh& mesh, const builder::MeshReport& report) {
  std::vector<std::size_t> count(mesh.part_names.size());
  std::vector<std::optional<std::uint32_t>> out(mesh.part_names.size());
  std::vector<bool> has_several(mesh.part_names.size());
  for (std::size_t t = 0; t < mesh.part.size(); ++t) {
    const std::uint32_t p = mesh.part[t], c = report.component_of[t];
    ++count[p];
    has_several[p] = has_several[p] || (out[p] && *out[p] != c);
    out[p] = c;
  }
  for (std::size_t p = 0; p < out.size(); ++p)
    if (out[p] && (has_several[p] || report.components[*out[p]].triangles != count[p])) out[p].reset();
  return out;
}

std::vector<PartLine> partsOf(const TriangleMesh& mesh, const builder::MeshReport& report, builder::Progress& progress) {
  std::vector<PartLine> lines;
  const auto add = [&](const std::string& name, std::optional<std::uint32_t> component, const TriangleMesh& part) {
    progress.check();
    const builder::MeshReport own = builder::checkMesh(part, builder::kPlacesListed, progress);
    lines.push_back({name, component, own.triangles, own.volume, own.low, own.high,
                     own.clean()     ? "sound"
                     : own.fixable() ? "inside out"
                                     : "defective"});
  };
  if (report.component_of.empty()) return lines;
  const std::vector<std::optional<std::uint32_t>> component_of_part = componentsOfParts(mesh, report);
  for (std::size_t p = 0; p < mesh.part_names.size(); ++p)
    add(mesh.part_names[p], component_of_part[p], formats::selectPart(mesh, mesh.part_names[p]));
  TriangleMesh by_component = mesh;
  by_component.part = report.component_of;
  by_component.part_names.clear();
  for (std::size_t c = 0; c < report.components.size(); ++c) by_component.part_names.push_back("#" + std::to_string(c));
  constexpr std::size_t kMaxComponents = 1000;  // each is checked separately
  for (std::uint32_t c = 0; c < std::min(kMaxComponents, report.components.size()); ++c)
    if (std::find(component_of_part.begin(), component_of_part.end(), c) == component_of_part.end())
      add(by_component.part_names[c], c, formats::selectPart(by_component, by_component.part_names[c]));
  return lines;
}

Json pointJson(const Eigen::Vector3d& p) {
  Json point = Json::array();
  for (const double x : p) point.push_back(std::isfinite(x) ? Json(x) : Json(nullptr));
  return point;
}

Json placeJson(const builder::Place& place) {
  return {{"triangles", place.triangles}, {"vertices", place.vertices}, {"at_mm", pointJson(place.point)}};
}

Json surveyJson(const builder::MeshSurvey& survey) {
  Json out;
  out["borders"] = Json::array();
  for (const builder::BorderShape& b : survey.borders)
    out["borders"].push_back({{"edges", b.edges},
                              {"length_mm", b.length},
                              {"loop", b.is_loop},
                              {"off_plane_mm", b.is_loop ? Json(b.off_plane) : Json(nullptr)},
                              {"roundness", b.is_loop ? Json(b.roundness) : Json(nullptr)},
                              {"centre_mm", pointJson(b.centre)},
                              {"vertices", b.vertices}});
  const auto seams = [](const std::vector<builder::Seam>& all, const char* other) {
    Json list = Json::array();
    for (const builder::Seam& s : all)
      list.push_back({{"vertex", s.vertex}, {other, s.other}, {"gap_mm", s.gap}, {"at_mm", pointJson(s.point)}});
    return list;
  };
  out["cracks"] = seams(survey.cracks, "other_vertex");
  out["t_junctions"] = seams(survey.t_junctions, "triangle");
  out["turned_triangles"] = survey.turned;
  out["one_sided_components"] = survey.one_sided;
  out["tiny_components"] = survey.tiny;
  out["unit_hint"] = survey.unit_hint.empty() ? Json(nullptr) : Json(survey.unit_hint);
  out["thickness_mm"] = nullptr;
  out["leaf_estimates"] = Json::array();
  if (!survey.has_inside) return out;
  const builder::Thickness& t = survey.thickness;
  out["thickness_mm"] = {{"min", t.smallest}, {"p05", t.fifth_percentile}, {"median", t.median}, {"max", t.largest}};
  for (const builder::LeafEstimate& e : survey.leaf_estimates)
    out["leaf_estimates"].push_back({{"overhang_mm", e.overhang}, {"leaves", e.leaves}});
  return out;
}

std::string partOf(const TriangleMesh& mesh, std::uint32_t triangle) {
  return mesh.part.empty() ? std::string() : mesh.part_names[mesh.part[triangle]];
}

Json toJson(const formats::MeshFile& file, const TriangleMesh& mesh, const builder::MeshReport& report,
            const builder::RepairedMesh& repaired, const builder::MeshSurvey& survey) {
  Json out;
  out["schema"] = "spheretree.check/1";
  out["format"] = file.format;
  out["unit_mm"] = file.unit_mm;
  out["clean"] = report.clean();
  out["build"] = buildOf(repaired);
  out["repair"] = pipeline::repairJson(repaired);
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
    line["places"] = Json::array();
    for (const builder::Place& place : defect.first) {
      if (line["first"].size() < builder::kPlacesListed) line["first"].push_back(placeJson(place));
      line["places"].push_back(placeJson(place));
    }
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
  out["survey"] = surveyJson(survey);
  out["not_checked"] = report.not_checked;
  out["notes"] = file.notes;
  return out;
}

void printText(const std::filesystem::path& input, const formats::MeshFile& file, const TriangleMesh& mesh,
               const builder::RepairedMesh& repaired, const builder::MeshSurvey& survey) {
  const builder::MeshReport& report = repaired.report;
  const Eigen::Vector3d size = report.high - report.low;
  printResult("%s: %s, %zu triangles, %zu vertices", plainText(formats::shownName(input)).c_str(), file.format.c_str(), report.triangles,
              report.vertices);
  if (!report.components.empty()) printResult(", %zu component%s", report.components.size(), report.components.size() == 1 ? "" : "s");
  printResult("\nbox %.6g x %.6g x %.6g mm, from %.6g %.6g %.6g to %.6g %.6g %.6g, area %.6g mm2, volume %.6g mm3\n", size.x(), size.y(),
              size.z(), report.low.x(), report.low.y(), report.low.z(), report.high.x(), report.high.y(), report.high.z(), report.area,
              report.volume);
  for (const std::string& note : file.notes) printResult("note: %s\n", plainText(note).c_str());
  for (const builder::Component& c : report.components) {
    if (!c.buried && !c.cavity) continue;
    const std::string part = partOf(mesh, c.first_triangle);
    printResult("note: the component of %zu triangles from triangle %u on%s %s\n", c.triangles, c.first_triangle,
                part.empty() ? "" : (" (part \"" + plainText(part) + "\")").c_str(),
                c.buried ? "lies wholly within solid matter: a build leaves it out." : "is a cavity.");
  }
  printResult("%s%s", report.summary().c_str(), summaryOf(survey, report).c_str());
  if (survey.has_inside) {
    const builder::Thickness& t = survey.thickness;
    printResult("thickness: median %.4g mm, 5 %% of the surface below %.4g mm, smallest %.4g mm\nleaves for an overhang of", t.median,
                t.fifth_percentile, t.smallest);
    const char* separator = " ";
    for (const builder::LeafEstimate& e : survey.leaf_estimates) {
      printResult("%s%.3g mm: %zu", separator, e.overhang, e.leaves);
      separator = ", ";
    }
    printResult(" (a formula; a build may need fewer, as teeth do, or more)\n");
  }
  if (report.clean())
    printResult("no defects: a build takes this mesh.\n");
  else
    printResult(repaired.isSound() ? "a build repairs this mesh and reports it:\n" : "a build refuses this mesh.\n");
  if (!report.clean())
    for (const builder::RepairStep& step : repaired.steps) printResult("  %s\n", step.text.c_str());
}

/// A colour for each kind, in the order of the report; then for the findings of the survey.
std::vector<formats::Marks> marksOf(const builder::MeshReport& report, const builder::MeshSurvey& survey) {
  constexpr std::array<std::array<double, 3>, 6> kColours{
      {{0.84, 0.15, 0.16}, {0.12, 0.47, 0.71}, {1.0, 0.6, 0.0}, {0.58, 0.30, 0.74}, {0.17, 0.63, 0.17}, {0.89, 0.30, 0.66}}};
  std::vector<formats::Marks> marks;
  const auto begin = [&](std::string_view name) -> formats::Marks& {
    marks.push_back({std::string(name), kColours[marks.size() % kColours.size()], {}, {}});
    return marks.back();
  };
  for (const builder::Defect& defect : report.defects) {
    formats::Marks& mark = begin(name(defect.kind));
    for (const builder::Place& place : defect.first) {
      mark.triangles.insert(mark.triangles.end(), place.triangles.begin(), place.triangles.end());
      const bool is_small = defect.kind != builder::DefectKind::SelfIntersection && defect.kind != builder::DefectKind::DuplicateFace;
      if (is_small) mark.points.push_back(place.point);
    }
  }
  const auto seams = [&](std::string_view name, const std::vector<builder::Seam>& all) {
    if (all.empty()) return;
    formats::Marks& mark = begin(name);
    for (const builder::Seam& seam : all) mark.points.push_back(seam.point);
  };
  seams("crack", survey.cracks);
  seams("T-junction", survey.t_junctions);
  if (!survey.turned.empty()) begin("turned triangle").triangles = survey.turned;
  formats::Marks& tiny = begin("tiny component");
  for (std::uint32_t t = 0; t < report.component_of.size(); ++t)
    if (std::binary_search(survey.tiny.begin(), survey.tiny.end(), report.component_of[t])) tiny.triangles.push_back(t);
  return marks;
}

Json partsJson(const std::vector<PartLine>& parts) {
  Json list = Json::array();
  for (const PartLine& p : parts)
    list.push_back({{"name", p.name},
                    {"component", p.component ? Json(*p.component) : Json(nullptr)},
                    {"triangles", p.triangles},
                    {"size_mm", pointJson(p.high_mm - p.low_mm)},
                    {"centre_mm", pointJson((p.low_mm + p.high_mm) / 2)},
                    {"box_mm", {{"low", pointJson(p.low_mm)}, {"high", pointJson(p.high_mm)}}},
                    {"volume_mm3", p.volume_mm3},
                    {"state", p.state}});
  return list;
}

void printParts(const std::vector<PartLine>& parts) {
  printResult("triangles    volume [mm3]  centre of its box [mm]                size of its box [mm]            state       part\n");
  for (const PartLine& p : parts) {
    const Eigen::Vector3d centre = (p.low_mm + p.high_mm) / 2, size = p.high_mm - p.low_mm;
    std::string name = plainText(p.name);
    if (p.component && p.name != "#" + std::to_string(*p.component)) name += " (#" + std::to_string(*p.component) + ")";
    printResult("%9zu  %14.6g  %10.4g %10.4g %10.4g  %9.4g %9.4g %9.4g  %-10s  %s\n", p.triangles, p.volume_mm3, centre.x(), centre.y(),
                centre.z(), size.x(), size.y(), size.z(), p.state, name.c_str());
  }
}

/// Whether the exit code reports a failure for a mesh.
bool fails(const CheckOptions& options, const builder::RepairedMesh& repaired) {
  if (options.fail_on == "nothing") return false;
  return options.fail_on == "defects" ? !repaired.report.clean() : !repaired.isSound();
}

/// Returns whether the mesh fails; `json`: with --json, the list that receives the findings instead of stdout.
bool checkOne(const CheckOptions& options, const std::filesystem::path& input, Json& json, builder::Progress& progress) {
  progress.stage("read");
  formats::MeshFile file = pipeline::readMeshIn(input, options.unit);
  progress.check();
  progress.stage("check");
  const TriangleMesh mesh = pipeline::choosePart(file.mesh, options.parts);
  const bool needs_all = options.json || !options.output.empty();
  const builder::RepairedMesh repaired = builder::repairMesh(mesh, builder::RepairKind::Auto, progress);
  const builder::MeshReport report =
      needs_all ? builder::checkMesh(mesh, std::numeric_limits<std::size_t>::max(), progress) : repaired.report;
  progress.check();
  progress.stage("survey");
  const builder::MeshSurvey survey = builder::surveyMesh(mesh, report, progress, file.unit_mm);
  const std::vector<PartLine> parts = options.list_parts ? partsOf(mesh, report, progress) : std::vector<PartLine>();
  progress.check();
  if (!options.output.empty()) formats::writeWhole(options.output, formats::encodeMarkedGlb(mesh, marksOf(report, survey)));
  if (isDash(options.output)) return fails(options, repaired);
  if (options.json) {
    Json out = toJson(file, mesh, report, repaired, survey);
    if (options.inputs.size() > 1) out["file"] = input.string();
    if (options.list_parts) out["part_list"] = partsJson(parts);
    json.push_back(std::move(out));
  } else {
    printText(input, file, mesh, repaired, survey);
    if (options.list_parts) printParts(parts);
  }
  return fails(options, repaired);
}

int runCheck(const CheckOptions& options, builder::Progress& progress) {
  const RunFiles files;
  for (const std::filesystem::path& input : options.inputs) files.willRead(input);
  files.willWrite(options.output, {".glb"}, "the marked mesh", false);
  if (isDash(options.output) && options.json)
    throw UsageError("--json and the marked mesh cannot both go to standard output. Name a file.");
  if (!options.output.empty() && options.inputs.size() > 1) throw UsageError("-o is for one mesh. Check them one by one, or leave it out.");
  bool failed = false;
  Json list = Json::array();
  for (const std::filesystem::path& input : options.inputs) {
    if (!options.json && &input != &options.inputs.front()) printResult("\n");
    failed |= checkOne(options, input, list, progress);
  }
  if (options.json && !isDash(options.output)) writeResult(jsonText(options.inputs.size() > 1 ? list : list[0], 2) + "\n");
  return failed ? kExitRefused : kExitOk;
}

}  // namespace

void addCheckCommand(Program& program) {
  const auto options = std::make_shared<CheckOptions>();
  CLI::App* app =
      addVerb(program, "check", "List the defects of a mesh, their places, and what a build does about them; exit code 4 if there are any",
              "spheretree check tooth.obj --json", [options](builder::Progress& progress) { return runCheck(*options, progress); });
  app->add_option("INPUT", options->inputs, "Meshes: .obj, .stl, .ply, .off, .gltf or .glb")->required()->type_name("FILE...");
  app->add_option(
         "--fail-on", options->fail_on,
         "Condition for exit code 4: defects: the mesh has any; unfixable: no repair makes it sound; nothing: never; default defects")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"defects", "unfixable", "nothing"}));
  app->add_option("-o,--output", options->output, "Also write the mesh with its defects coloured (.glb); default: none")->type_name("FILE");
  app->add_flag("--list-parts", options->list_parts,
                "Also list the named parts and the connected components, each checked alone; default off");
  app->add_flag("--json", options->json, "Print JSON on stdout, schema spheretree.check/1; for several meshes a list");
  addUnit(*app, options->unit);
  addParts(*app, options->parts);
}

}  // namespace spheretree::tool
