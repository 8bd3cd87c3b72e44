// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree soften: makes a tree that moves with soft tissue. Content and use of the file: docs/tissue.md
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "input/tree_input.h"
#include "json_text.h"
#include "options/command.h"
#include "options/common_options.h"
#include "pipeline/part_choice.h"
#include "pipeline/sound_mesh.h"
#include "pipeline/tissue/fill_body.h"
#include "pipeline/tissue/fixed_regions.h"
#include "run_files.h"
#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/builder/soften_tree.h"
#include "spheretree/core/mesh_edit.h"
#include "spheretree/core/tissue_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

struct SoftenOptions {
  std::filesystem::path mesh, tree, output;
  std::string parts = "merge", unit, repair = "auto";
  std::vector<std::string> fixed;
  std::vector<std::filesystem::path> fixed_inside;
  TissueMaterial material{0, 0.45, 1040};
  int tetrahedra = pipeline::kUsualTetrahedra;
  double seconds = 60;
  bool json = false;
};

pipeline::FixedRegions fixedRegions(const SoftenOptions& options) {
  pipeline::FixedRegions regions;
  for (const std::string& text : options.fixed)
    if (!pipeline::addFixedRegion(text, regions))
      throw UsageError("--fix " + text + ": a region is sphere:X,Y,Z,RADIUS or box:X0,Y0,Z0,X1,Y1,Z1 in mm, the lower corner first.");
  for (const std::filesystem::path& path : options.fixed_inside) addLeaves(readTree(path), regions);
  if (regions.empty()) throw UsageError("the body is not held. Name a fixed region with --fix or --fix-inside.");
  return regions;
}

void report(const SoftenOptions& options, const Tissue& tissue, const pipeline::FilledBody& body, std::size_t bytes) {
  if (options.json) {
    const nlohmann::ordered_json out{{"schema", "spheretree.softening/1"},
                                     {"mesh", options.mesh.string()},
                                     {"tree", options.tree.string()},
                                     {"output", options.output.string()},
                                     {"bytes", bytes},
                                     {"young_kpa", tissue.material.young_kpa},
                                     {"poisson", tissue.material.poisson},
                                     {"density_kg_m3", tissue.material.density_kg_m3},
                                     {"nodes", tissue.nodes.size()},
                                     {"fixed_nodes", tissue.fixed.size()},
                                     {"tetrahedra", tissue.tetrahedra.size()},
                                     {"pressed_nodes", tissue.response.pressed.size()},
                                     {"boundary_triangles", body.boundary.triangles.size()},
                                     {"boundary_distance_mm", body.boundary_distance_mm}};
    return writeResult(jsonText(out, 2) + "\n");
  }
  printResult("%s: %zu tetrahedra, %zu nodes, %zu of them fixed; %zu bytes\n", plainText(options.output.string()).c_str(),
              tissue.tetrahedra.size(), tissue.nodes.size(), tissue.fixed.size(), bytes);
  if (tissue.response.empty())
    printResult("  too many nodes for their compliance matrix: players refuse this file. Give half of this number with --tets\n");
  if (body.boundary_distance_mm > 0)
    printResult("  they fill a simplified surface of %zu triangles; no point of the mesh is farther from it than %.3g mm\n",
                body.boundary.triangles.size(), body.boundary_distance_mm);
}

int runSoften(const SoftenOptions& options, builder::Progress& progress) {
  const RunFiles files;
  files.willRead(options.mesh);
  files.willRead(options.tree);
  for (const std::filesystem::path& path : options.fixed_inside) files.willRead(path);
  files.willWrite(options.output, {".soft"}, "the soft tree", false);
  if (isDash(options.output) && options.json) throw UsageError("--json and the soft tree cannot both go to standard output. Name a file.");
  if (const std::string fault = findFault(options.material); !fault.empty()) throw UsageError(fault + ".");
  progress.stage("read");
  const SphereTree tree = readTree(options.tree);
  const pipeline::FixedRegions fixed = fixedRegions(options);
  const formats::MeshFile file = pipeline::readMeshIn(options.mesh, options.unit);
  std::vector<std::string> notes;
  const builder::RepairedMesh mesh = pipeline::soundMesh(pipeline::choosePart(file.mesh, options.parts), formats::shownName(options.mesh),
                                                         pipeline::repairKind(options.repair), notes, progress);
  if (tree.provenance.mesh_hash != builder::meshHash(mesh.mesh))
    throw builder::BuildError(formats::shownName(options.tree) + " was not built from " + formats::shownName(options.mesh) +
                              ", or with another --unit, --parts or --repair. Build it again from this mesh");
  const pipeline::FilledBody body = pipeline::fillBody(mesh.mesh, options.tetrahedra, options.seconds, progress);
  const Tissue tissue = builder::softenTree(
      joined(mesh.mesh, mesh.to_cover), tree, body.boundary, body.tetrahedra, options.material,
      [&](const Eigen::Vector3d& p) { return fixed.holds(p); }, progress);
  progress.check();
  const std::vector<std::byte> bytes = encodeSoftTree(tree, tissue);
  clearProgressLine();
  formats::writeWhole(options.output, bytes);
  if (!isDash(options.output)) report(options, tissue, body, bytes.size());
  return kExitOk;
}

}  // namespace

void addSoftenCommand(Program& program) {
  const auto options = std::make_shared<SoftenOptions>();
  CLI::App* app = addVerb(program, "soften", "Fill an object with tetrahedra, so that its tree deforms as soft tissue",
                          "spheretree soften tongue.obj tongue.stree -o tongue.soft --young 15 \\\n    --fix box:-40,-40,-20,40,40,-5",
                          [options](builder::Progress& progress) { return runSoften(*options, progress); });
  app->add_option("MESH", options->mesh, "Mesh that the tree was built from")->required()->type_name("FILE");
  app->add_option("TREE", options->tree, "Tree of this mesh (.stree)")->required()->type_name("FILE");
  app->add_option("-o,--output", options->output, "Soft tree to write (.soft)")->required()->type_name("FILE");
  app->add_option("--young", options->material.young_kpa, "Young's modulus in kPa, 0.1 to 100000; tongue 15, cheek 30, gum 3000")
      ->required()
      ->type_name("KPA");
  app->add_option("--poisson", options->material.poisson, "Poisson's ratio, 0 to 0.495; default 0.45")->type_name("RATIO");
  app->add_option("--density", options->material.density_kg_m3, "Density in kg/m3, 100 to 5000; default 1040")->type_name("KG/M3");
  app->add_option("--tets", options->tetrahedra, "Approximate number of tetrahedra, 100 to 50000; default 3000")
      ->type_name("N")
      ->check(CLI::Range(pipeline::kMinTetrahedra, pipeline::kMaxTetrahedra));
  app->add_option("--fix", options->fixed,
                  "Region that stays in place: sphere:X,Y,Z,RADIUS or box:X0,Y0,Z0,X1,Y1,Z1, in mm; may be given again")
      ->type_name("REGION");
  app->add_option("--fix-inside", options->fixed_inside,
                  "Tree that holds the body: the tissue inside its leaves stays in place; may be given again")
      ->type_name("TREE");
  app->add_option("--time-limit", options->seconds, "Seconds for each run of TetGen, 1 to 3600; default 60")
      ->type_name("S")
      ->check(CLI::Range(1.0, 3600.0));
  app->add_option("--repair", options->repair, "As for the build of the tree: auto, off or wrap; default auto")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "off", "wrap"}));
  app->add_flag("--json", options->json, "Print the figures of the result as JSON on stdout, schema spheretree.softening/1");
  addUnit(*app, options->unit);
  addParts(*app, options->parts);
}

}  // namespace spheretree::tool
