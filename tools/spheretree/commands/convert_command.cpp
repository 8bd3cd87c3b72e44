// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree convert: one form of a tree to another, or to a picture, by the names' endings.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numeric>

#include "commands/command.h"
#include "commands/tree_input.h"
#include "mistyped.h"
#include "page/picture.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sph_text.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "spheretree/formats/tree_glb.h"
#include "spheretree/formats/tree_json.h"

namespace spheretree::tool {
namespace {

struct ConvertOptions {
  std::filesystem::path input, output, mesh;
  std::string spheres, to;
  std::vector<double> view;
  int width = 0;
};

std::vector<std::byte> pictureOf(const SphereTree& tree, SphereKind kind, const ConvertOptions& options) {
  PictureSettings settings;
  if (!options.view.empty()) std::copy(options.view.begin(), options.view.end(), settings.view.begin());
  if (options.width > 0) settings.width = options.width;
  if (options.mesh.empty()) return drawPicture(nullptr, tree, kind, settings);
  const double unit = tree.provenance.unit_mm;
  const TriangleMesh mesh = formats::readMesh(options.mesh, unit, unit == 1 ? formats::unitInMm("m") : unit).mesh;
  return drawPicture(&mesh, tree, kind, settings);
}

int runConvert(const ConvertOptions& options, builder::Progress& progress) {
  const RunFiles files;
  const std::string to = options.to.empty() ? endingOf(options.output) : "." + options.to;
  if (to.empty() && isDash(options.output)) throw UsageError("say what standard output is to hold: --to stree, sph, json, glb or png.");
  if (!options.to.empty() && !isDash(options.output) && to != endingOf(options.output))
    throw UsageError(options.output.string() + ": the name does not end in " + to + ", as --to says. Leave --to out.");
  files.willRead(options.input);
  if (!options.mesh.empty()) files.willRead(options.mesh);
  files.willWrite(options.output, {".stree", ".sph", ".json", ".glb", ".png"}, "the output", to == ".sph" || to == ".json");
  if (to != ".png" && (!options.mesh.empty() || !options.view.empty() || options.width > 0))
    throw UsageError("--mesh, --view and --width are for pictures (.png). Leave them out.");
  const double length =
      std::accumulate(options.view.begin(), options.view.end(), 0.0, [](double sum, double v) { return sum + std::abs(v); });
  if (!options.view.empty() && !(length > 0)) throw UsageError("--view is no direction. Give a point to look from, such as 1,-2,1.");
  if (!options.spheres.empty() && to != ".sph" && to != ".glb" && to != ".png")
    throw UsageError("--spheres is for .sph, .glb and .png; " + to + " always holds both kinds of spheres. Leave it out.");
  const SphereKind kind = options.spheres == "bound" ? SphereKind::Bound : SphereKind::Cover;

  SphereTree tree = readTree(options.input);
  if (tree.provenance.generator.empty()) tree.provenance.generator = kGenerator;
  progress.check();
  if (to == ".stree")
    formats::writeSphereTree(options.output, tree);
  else if (to == ".sph")
    formats::writeWhole(options.output, formats::writeSph(tree, kind));
  else if (to == ".json")
    formats::writeWhole(options.output, formats::writeTreeJson(tree));
  else if (to == ".png")
    formats::writeWhole(options.output, pictureOf(tree, kind, options));
  else
    formats::writeWhole(options.output, formats::encodeGlb(tree, kind));
  return kExitOk;
}

}  // namespace

void addConvertCommand(Program& program) {
  const auto options = std::make_shared<ConvertOptions>();
  CLI::App* app = addVerb(program, "convert", "Convert a tree: .stree, .sph or .json to .stree, .sph, .json, .glb or a picture (.png)",
                          "spheretree convert tooth.stree tooth.glb --spheres cover",
                          [options](builder::Progress& progress) { return runConvert(*options, progress); });
  app->add_option("IN", options->input, "Tree to read; its kind is told from the ending .stree, .sph or .json")
      ->required()
      ->type_name("FILE");
  app->add_option("OUT", options->output, "File to write; its kind is told from the ending .stree, .sph, .json, .glb or .png")
      ->required()
      ->type_name("FILE");
  app->add_option("--to", options->to,
                  "Kind of the output where OUT is - (standard output): stree, sph, json, glb or png; default: by the ending of OUT")
      ->type_name("KIND")
      ->check(CLI::IsMember({"stree", "sph", "json", "glb", "png"}));
  app->add_option(
         "--spheres", options->spheres,
         "Spheres of inner nodes in .sph, .glb and .png: cover (the approximation) or bound (what a traversal tests); default cover")
      ->type_name("KIND")
      ->check(CLI::IsMember({"cover", "bound"}));
  app->add_option("--mesh", options->mesh, "Mesh that the tree was built from, to be drawn beside it in .png; default: none")
      ->type_name("FILE");
  app->add_option("--view", options->view, "Direction from the object to the eye in .png, three numbers; default 1,-2,1")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(numberIn(-1e6, 1e6));
  app->add_option("--width", options->width, "Width of the .png in pixels, 100 to 3000; default 1600")
      ->type_name("N")
      ->check(CLI::Range(kMinPictureWidth, kMaxPictureWidth));
}

}  // namespace spheretree::tool
