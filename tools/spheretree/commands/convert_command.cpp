// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree convert: converts a tree to another format or a picture, or the recording of a cut to the mesh of what is
// left, according to the extensions of the names.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <span>

#include "cut/remaining_mesh.h"
#include "input/tree_input.h"
#include "mistyped.h"
#include "options/command.h"
#include "page/picture.h"
#include "pipeline/cut/cut_run.h"
#include "run_files.h"
#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/mesh_writer.h"
#include "spheretree/formats/sph_text.h"
#include "spheretree/formats/sphere_list.h"
#include "spheretree/formats/tree_glb.h"
#include "spheretree/formats/tree_json.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

struct ConvertOptions {
  std::filesystem::path input, output, mesh;
  std::string spheres, to, unit;
  std::vector<double> view;
  int width = 0, level = -1;
  // Of a recording:
  std::string object;
  std::uint64_t last_tick = pipeline::kWholeRun;
  double tolerance = 0;
};

constexpr double kTolerance = 0.02;  // of the mesh of what is left, by default [mm]

const std::vector<std::string> kKinds{"stree", "sph", "json", "csv", "yaml", "glb", "png"};

std::vector<std::byte> pictureOf(const SphereTree& tree, SphereKind kind, const ConvertOptions& options, bool quiet) {
  PictureSettings settings;
  if (!options.view.empty()) std::copy(options.view.begin(), options.view.end(), settings.view.begin());
  if (options.width > 0) settings.width = options.width;
  if (options.mesh.empty()) return drawPicture(nullptr, tree, kind, settings);
  const double unit = tree.provenance.unit_mm;
  const TriangleMesh mesh = formats::readMesh(options.mesh, unit, unit == 1 ? formats::unitInMm("m") : unit).mesh;
  if (const std::string warning = otherMeshWarning(tree, options.input, mesh, options.mesh); !quiet && !warning.empty())
    say("spheretree: warning: " + warning);
  return drawPicture(&mesh, tree, kind, settings);
}

/// Refuses options that only other kinds of output use.
void refuseStrayOptions(const ConvertOptions& options, const std::string& to) {
  if (to != ".png" && (!options.mesh.empty() || !options.view.empty() || options.width > 0))
    throw UsageError("--mesh, --view and --width are for pictures (.png). Leave them out.");
  const double length =
      std::accumulate(options.view.begin(), options.view.end(), 0.0, [](double sum, double v) { return sum + std::abs(v); });
  if (!options.view.empty() && !(length > 0)) throw UsageError("--view is the zero vector. Give a direction to look from, such as 1,-2,1.");
  const bool is_list = to == ".csv" || to == ".yaml" || (to == ".json" && options.level >= 0);
  if (options.level >= 0 && !is_list && to != ".glb")
    throw UsageError("--level is for lists of spheres (.csv, .yaml, .json) and .glb; " + to + " holds the whole tree. Leave it out.");
  if (!options.unit.empty() && !is_list)
    throw UsageError("--unit is for lists of spheres: .csv, .yaml, or .json with --level. Leave it out.");
  if (!options.spheres.empty() && (to == ".stree" || (to == ".json" && !is_list)))
    throw UsageError("--spheres is for .sph, .csv, .yaml, .glb and .png; " + to + " always holds both kinds of spheres. Leave it out.");
}

/// The content of the output; `to`: its extension.
std::vector<std::byte> converted(const SphereTree& tree, const ConvertOptions& options, const std::string& to, bool quiet) {
  const SphereKind kind = options.spheres == "bound" ? SphereKind::Bound : SphereKind::Cover;
  if (options.level >= tree.levelCount())
    throw UsageError("--level " + std::to_string(options.level) + ": the tree has the levels 0 to " +
                     std::to_string(tree.levelCount() - 1) + ".");
  const formats::SphereListSettings list{.level = options.level >= 0 ? options.level : tree.levelCount() - 1,
                                         .unit = options.unit.empty() ? "mm" : options.unit,
                                         .kind = kind,
                                         .name = isDash(options.input) ? "spheres" : options.input.stem().string()};
  const auto bytesOf = [](const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return std::vector<std::byte>(bytes.begin(), bytes.end());
  };
  if (to == ".stree") return encodeSphereTree(tree);
  if (to == ".sph") return bytesOf(formats::writeSph(tree, kind));
  if (to == ".csv") return bytesOf(formats::sphereListCsv(tree, list));
  if (to == ".yaml") return bytesOf(formats::sphereListYaml(tree, list));
  if (to == ".json") return bytesOf(options.level >= 0 ? formats::sphereListJson(tree, list) : formats::writeTreeJson(tree));
  if (to == ".png") return pictureOf(tree, kind, options, quiet);
  return formats::encodeGlb(tree, kind, options.level >= 0 ? std::optional(options.level) : std::nullopt);
}

const pipeline::CutRun::Object& chooseObject(const pipeline::CutRun& run, const ConvertOptions& options) {
  std::string names;
  for (const pipeline::CutRun::Object& object : run.objects) {
    if (object.name == options.object || (options.object.empty() && run.objects.size() == 1)) return object;
    names += (names.empty() ? "" : ", ") + object.name;
  }
  if (options.object.empty())
    throw UsageError(options.input.string() + ": several objects can be cut: " + names + ". Name one with --object.");
  throw UsageError("--object " + options.object + ": no object with this name can be cut; there is " + names + ". Name it.");
}

/// Writes what a recorded burr left of an object.
int convertRecording(const ConvertOptions& options, builder::Progress& progress) {
  const RunFiles files;
  files.willRead(options.input);
  if (!options.to.empty()) throw UsageError("--to is for trees; a recording becomes .ply or .obj, by the name of OUT. Leave it out.");
  files.willWrite(options.output, {".ply", ".obj"}, "what is left", false);
  refuseStrayOptions(options, endingOf(options.output));
  const pipeline::CutRun run = pipeline::readCutRun(options.input, options.last_tick, progress);
  const pipeline::CutRun::Object& object = chooseObject(run, options);
  const double tolerance = options.tolerance > 0 ? options.tolerance : kTolerance;
  const builder::RemainingMesh left = builder::remainingMesh(object.layers[0].mesh, object.paths, tolerance, progress);
  clearProgressLine();
  formats::writeWhole(options.output, endingOf(options.output) == ".obj" ? formats::encodeObj(left.mesh) : formats::encodePly(left.mesh));
  if (!isDash(options.output))
    printResult("%s: %s, %zu triangles, within %.3g mm of what is left\n", plainText(options.output.string()).c_str(),
                plainText(object.name).c_str(), left.mesh.triangles.size(), left.bound);
  return kExitOk;
}

int runConvert(const ConvertOptions& options, bool quiet, builder::Progress& progress) {
  if (endingOf(options.input) == ".csv") return convertRecording(options, progress);
  if (!options.object.empty() || options.last_tick != pipeline::kWholeRun || options.tolerance > 0)
    throw UsageError("--object, --at and --tolerance are for recordings (.csv). Leave them out.");
  const RunFiles files;
  const std::string to = options.to.empty() ? endingOf(options.output) : "." + options.to;
  if (to.empty() && isDash(options.output))
    throw UsageError("the kind of the output is needed for standard output. Add --to stree, sph, json, csv, yaml, glb or png.");
  if (!options.to.empty() && !isDash(options.output) && to != endingOf(options.output))
    throw UsageError(options.output.string() + ": the name does not end in " + to + ", as --to says. Leave --to out.");
  files.willRead(options.input);
  if (!options.mesh.empty()) files.willRead(options.mesh);
  const bool is_text = to != ".stree" && to != ".glb" && to != ".png";
  files.willWrite(options.output, {".stree", ".sph", ".json", ".csv", ".yaml", ".glb", ".png"}, "the output", is_text);
  refuseStrayOptions(options, to);
  SphereTree tree = readTree(options.input);
  if (tree.provenance.generator.empty()) tree.provenance.generator = kGenerator;
  progress.check();
  const std::vector<std::byte> bytes = converted(tree, options, to, quiet);
  clearProgressLine();
  formats::writeWhole(options.output, bytes);
  return kExitOk;
}

}  // namespace

void addConvertCommand(Program& program) {
  const auto options = std::make_shared<ConvertOptions>();
  CLI::App* app = addVerb(program, "convert",
                          "Convert a tree (.stree, .sph, .json) to these, a list of spheres (.csv, .yaml), .glb or a picture (.png); or "
                          "the recording of a cut (.csv) to a mesh of what is left (.ply, .obj)",
                          "spheretree convert tooth.stree tooth.glb --spheres cover",
                          [options, &program](builder::Progress& progress) { return runConvert(*options, program.quiet, progress); });
  app->add_option(
         "IN", options->input,
         "Tree to read; its ending gives its kind: .stree, .sph or .json; or a recording of haptic-player (.csv) in which a burr cuts")
      ->required()
      ->type_name("FILE");
  app->add_option("OUT,-o,--output", options->output,
                  "File to write; its ending gives its kind: .stree, .sph, .json, .csv, .yaml, .glb or .png; of a recording .ply or .obj")
      ->required()
      ->type_name("FILE");
  app->add_option(
         "--to", options->to,
         "Kind of the output where OUT is - (standard output): stree, sph, json, csv, yaml, glb or png; default: by the ending of OUT")
      ->type_name("KIND")
      ->check(CLI::IsMember(kKinds));
  app->add_option("--spheres", options->spheres,
                  "Spheres of inner nodes in .sph, lists, .glb and .png: cover (the approximation) or bound (the bounding sphere that a "
                  "traversal tests); default cover")
      ->type_name("KIND")
      ->check(CLI::IsMember({"cover", "bound"}));
  app->add_option(
         "--level", options->level,
         "Only the spheres of this level, 0 (the root) to 5: as a list in .csv, .yaml and .json, as a mesh in .glb; default: the leaves "
         "in a list, all levels in .glb, the whole tree in .json")
      ->type_name("N")
      ->check(CLI::Range(0, kMaxLevels - 1));
  app->add_option("--unit", options->unit, "Unit of a list of spheres: mm, cm, m or in; default mm")
      ->type_name("UNIT")
      ->check(CLI::IsMember({"mm", "cm", "m", "in"}));
  app->add_option("--mesh", options->mesh, "Mesh of the tree, drawn beside it in .png; default: none")->type_name("FILE");
  app->add_option("--view", options->view, "Direction from the object to the eye in .png, three numbers; default 1,-2,1")
      ->type_name("X,Y,Z")
      ->delimiter(',')
      ->expected(3)
      ->check(numberIn(-1e6, 1e6));
  app->add_option("--object", options->object, "Object of a recording; default: the only one that can be cut")->type_name("NAME");
  app->add_option("--at", options->last_tick, "Tick of a recording up to which it counts; default: all of it")->type_name("TICK");
  app->add_option("--tolerance", options->tolerance,
                  "How far the mesh may be from what is left of an object in a recording, in mm, 0.0001 to 100; default 0.02")
      ->type_name("MM")
      ->check(numberIn(1e-4, 100));
  app->add_option("--width", options->width, "Width of the .png in pixels, 100 to 3000; default 1600")
      ->type_name("N")
      ->check(CLI::Range(kMinPictureWidth, kMaxPictureWidth));
}

}  // namespace spheretree::tool
