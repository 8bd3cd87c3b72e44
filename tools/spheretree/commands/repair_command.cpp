// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree repair: writes a mesh as a build uses it, with the repair steps.
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "json_text.h"
#include "options/command.h"
#include "options/common_options.h"
#include "pipeline/part_choice.h"
#include "pipeline/sound_mesh.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_writer.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

struct RepairOptions {
  std::filesystem::path input, output;
  std::string parts = "merge", unit, repair = "auto";
  bool json = false;
};

int runRepair(const RepairOptions& options, builder::Progress& progress) {
  const RunFiles files;
  files.willRead(options.input);
  files.willWrite(options.output, {".ply", ".obj"}, "the repaired mesh", false);
  if (isDash(options.output) && options.json) throw UsageError("--json and the mesh cannot both go to standard output. Name a file.");
  progress.stage("read");
  const formats::MeshFile file = pipeline::readMeshIn(options.input, options.unit);
  const TriangleMesh mesh = pipeline::choosePart(file.mesh, options.parts);
  progress.check();
  progress.stage("repair");
  std::vector<std::string> steps;
  const std::string name = formats::shownName(options.input);
  const builder::RepairedMesh repaired = pipeline::soundMesh(mesh, name, pipeline::repairKind(options.repair), steps, progress);
  progress.check();
  const bool is_obj = endingOf(options.output) == ".obj";
  clearProgressLine();
  formats::writeWhole(options.output, is_obj ? formats::encodeObj(repaired.mesh) : formats::encodePly(repaired.mesh));
  if (isDash(options.output)) return kExitOk;
  if (options.json) {
    nlohmann::ordered_json out{{"schema", "spheretree.repair/1"},
                               {"input", options.input.string()},
                               {"output", options.output.string()},
                               {"triangles", repaired.mesh.triangles.size()},
                               {"vertices", repaired.mesh.positions.size()},
                               {"repair", pipeline::repairJson(repaired)}};
    writeResult(jsonText(out, 2) + "\n");
    return kExitOk;
  }
  printResult("%s: %zu triangles, sound\n", plainText(options.output.string()).c_str(), repaired.mesh.triangles.size());
  if (steps.empty()) printResult("  nothing had to be done\n");
  for (const std::string& step : steps) printResult("  %s\n", plainText(step).c_str());
  return kExitOk;
}

}  // namespace

void addRepairCommand(Program& program) {
  const auto options = std::make_shared<RepairOptions>();
  CLI::App* app =
      addVerb(program, "repair", "Write the mesh that a build would use: closed, wound outward, without crossings",
              "spheretree repair scan.stl -o sound.ply", [options](builder::Progress& progress) { return runRepair(*options, progress); });
  app->add_option("INPUT", options->input, "Mesh to read: .obj, .stl, .ply, .off, .gltf or .glb")->required()->type_name("FILE");
  app->add_option("-o,--output", options->output, "Mesh to write, in mm: .ply, or .obj, which keeps the names of parts; - is PLY")
      ->required()
      ->type_name("FILE");
  app->add_option("--repair", options->repair,
                  "auto: the smallest change that makes the mesh sound; wrap: a closed surface around any mesh; default auto")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "wrap"}));
  app->add_flag("--json", options->json, "Print what was done as JSON on stdout, schema spheretree.repair/1");
  addUnit(*app, options->unit);
  addParts(*app, options->parts);
}

}  // namespace spheretree::tool
