// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree build: mesh to sphere-tree.
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "base/useful_threads.h"
#include "input/tree_input.h"
#include "json_text.h"
#include "measure/evaluate_skin.h"
#include "mistyped.h"
#include "options/command.h"
#include "options/common_options.h"
#include "pipeline/builder_names.h"
#include "pipeline/evaluation_json.h"
#include "pipeline/missed_tolerance.h"
#include "pipeline/part_choice.h"
#include "pipeline/sound_mesh.h"
#include "run_files.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "spheretree/formats/sph_text.h"
#include "spheretree/formats/sphere_tree_file.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

using builder::BuilderKind;
using builder::Quality;
using Json = nlohmann::ordered_json;

struct BuildOptions {
  std::vector<std::filesystem::path> inputs;
  std::filesystem::path input, output, report;  // of one tree
  std::filesystem::path uncertified;
  std::string builder = "cover", quality = "standard", medial_axis = "adaptive", unit, repair = "auto", parts = "merge", skin = "auto",
              shape = "balls";
  std::vector<std::string> combine;
  builder::BuildSettings settings;
  bool crease_angle_is_given = false, lower_bound = false;
};

void checkOptions(const BuildOptions& options, const RunFiles& files) {
  if (!options.combine.empty() && options.builder != "combined")
    throw UsageError("--combine is for --builder combined. Leave one of them out.");
  const bool is_published = options.builder != "cover", searches = !is_published || options.settings.search;
  if (options.settings.search && !is_published)
    throw UsageError("--search is for published builders; cover always searches. Leave it out.");
  if (options.settings.max_leaves > 0 && !searches)
    throw UsageError("--leaves needs a search, since a published method makes as many leaves as it makes. Add --search, or leave it out.");
  if (options.medial_axis != "adaptive" && !std::ranges::count(std::array{"merge", "burst", "expand", "combined"}, options.builder))
    throw UsageError("--medial-axis is for --builder merge, burst, expand and combined. Leave one of them out.");
  if (!options.uncertified.empty() && searches)
    throw UsageError(
        "--uncertified is for published builders without --search: a search knows the surface between its points. Leave it out.");
  if (options.settings.soft_share > 0 && options.builder != "cover")
    throw UsageError("--soft is for --builder cover. Leave one of them out.");
  if (options.skin == "off" && options.crease_angle_is_given)
    throw UsageError("--crease-angle needs a skin, and --skin off builds none. Leave one of them out.");
  if (options.lower_bound && (options.settings.tolerance_mm == 0 || options.shape == "hulls"))
    throw UsageError(
        "--lower-bound states how many spheres a --tolerance needs. Add one, without --shape hulls, or see spheretree evaluate --help.");
  files.willRead(options.input);
  files.willWrite(options.output, {".stree"}, "the tree (for other forms, see spheretree convert)", false);
  files.willWrite(options.report, {".json"}, "the report");
  files.willWrite(options.uncertified, {".sph"}, "the spheres before certification");
}

using Stages = std::vector<builder::BuildStatistics::Stage>;

/// The seconds of the whole command so far: `own`, then the stages of the build, each name once.
Stages allStages(Stages own, const builder::BuildStatistics& statistics) {
  for (const builder::BuildStatistics::Stage& stage : statistics.stages) {
    const auto at = std::ranges::find(own, stage.name, &builder::BuildStatistics::Stage::name);
    if (at == own.end())
      own.push_back(stage);
    else
      at->seconds += stage.seconds;
  }
  return own;
}

double secondsOf(const Stages& stages) {
  double sum = 0;
  for (const builder::BuildStatistics::Stage& stage : stages) sum += stage.seconds;
  return sum;
}

Json settingsJson(const BuildOptions& options) {
  const builder::BuildSettings& s = options.settings;
  Json settings;
  settings["builder"] = name(s.builder);
  settings["combine"] = options.combine;
  settings["search"] = s.searches();
  settings["medial_axis"] = name(s.medial_axis);
  settings["levels"] = s.levels;
  settings["branching"] = s.branching;
  settings["leaves"] = s.max_leaves > 0 ? Json(s.max_leaves) : Json(nullptr);
  settings["quality"] = name(s.quality);
  settings["tolerance_mm"] = s.tolerance_mm > 0 ? Json(s.tolerance_mm) : Json(nullptr);
  settings["soft_share"] = s.soft_share > 0 ? Json(s.soft_share) : Json(nullptr);
  settings["skin_mm"] = !s.skin ? Json("off") : s.skin_tolerance_mm > 0 ? Json(s.skin_tolerance_mm) : Json("auto");
  settings["hulls"] = s.hulls;
  settings["hull_tolerance_mm"] = s.hulls && s.hull_tolerance_mm > 0 ? Json(s.hull_tolerance_mm) : Json(nullptr);
  settings["crease_angle_deg"] = s.crease_angle_deg;
  settings["unit_mm"] = s.unit_mm;
  settings["parts"] = options.parts;
  settings["repair"] = options.repair;
  settings["simplify"] = s.simplify;
  settings["seed"] = s.seed;
  settings["threads"] = s.threads;
  return settings;
}

Json reportOf(const BuildOptions& options, const builder::RepairedMesh& repaired, const builder::BuildResult& result,
              const std::vector<std::string>& notes, std::size_t least_spheres, const Stages& stages) {
  const builder::BuildSettings& s = options.settings;
  const builder::BuildStatistics& statistics = result.statistics;
  const TriangleMesh& mesh = repaired.mesh;
  Json out;
  out["schema"] = "spheretree.build/1";
  out["generator"] = kGenerator;
  out["input"] = options.input.string();
  out["output"] = options.output.string();
  out["settings"] = settingsJson(options);
  out["settings_hash"] = toHex(builder::settingsHash(s));
  out["mesh"] = {{"triangles", mesh.triangles.size()},          {"vertices", mesh.positions.size()},
                 {"hash", toHex(builder::meshHash(mesh))},      {"diagonal_mm", result.tree.provenance.diagonal_mm},
                 {"area_mm2", result.tree.provenance.area_mm2}, {"volume_mm3", result.tree.provenance.volume_mm3}};
  out["repair"] = pipeline::repairJson(repaired);
  out["notes"] = notes;
  out["nodes"] = result.tree.nodeCount();
  out["inner_nodes"] = result.tree.bound.size();
  out["levels"] = Json::array();
  for (std::size_t level = 0; level < statistics.levels.size(); ++level) {
    const builder::LevelBuildStatistics& l = statistics.levels[level];
    out["levels"].push_back(
        {{"level", level}, {"spheres", l.spheres}, {"overhang_bound_mm", l.overhang_bound_mm}, {"largest_growth_mm", l.largest_growth_mm}});
  }
  out["skin"] = result.tree.skin.empty() ? Json(nullptr) : pipeline::skinJson(builder::skinFigures(result.tree.skin));
  out["hulls"] = pipeline::hullsJson(result.tree.hulls);
  const builder::Simplification& simplification = statistics.simplification;
  out["simplification"] = simplification.triangles == 0
                              ? Json(nullptr)
                              : Json{{"triangles", simplification.triangles}, {"distance_bound_mm", simplification.distance_bound_mm}};
  out["certified_pieces"] = statistics.certified_pieces;
  out["tolerance_met"] = s.tolerance_mm > 0 ? Json(statistics.tolerance_met) : Json(nullptr);
  out["least_spheres"] = options.lower_bound ? Json(least_spheres) : Json(nullptr);
  out["stages"] = Json::array();
  for (const builder::BuildStatistics::Stage& stage : stages) out["stages"].push_back({{"name", stage.name}, {"seconds", stage.seconds}});
  out["seconds"] = secondsOf(stages);
  return out;
}

/// For example ": repair 61.2 s, balls 1.6 s"; empty if no stage is long.
std::string longStages(const Stages& stages) {
  constexpr double kLong = 0.5;  // [s]
  std::string text;
  for (const builder::BuildStatistics::Stage& stage : stages) {
    if (stage.seconds < kLong) continue;
    char part[64];
    std::snprintf(part, sizeof part, "%s %.1f s", stage.name.c_str(), stage.seconds);
    text += (text.empty() ? ": " : ", ") + std::string(part);
  }
  return text;
}

void printSummary(const BuildOptions& options, const builder::BuildResult& result, std::size_t least_spheres, const Stages& stages) {
  const std::size_t nodes = result.tree.nodeCount();
  printResult("%s: %zu node%s, every level covers the surface; %.1f s%s\n", plainText(options.output.string()).c_str(), nodes,
              nodes == 1 ? "" : "s", secondsOf(stages), longStages(stages).c_str());
  // A published method covers points of the surface; what it takes to cover what lies between belongs to its figures.
  const bool shows_growth = !options.settings.searches();
  printResult("level  spheres  overhang bound [mm]%s\n", shows_growth ? "  certification added [mm]" : "");
  for (std::size_t level = 0; level < result.statistics.levels.size(); ++level) {
    const builder::LevelBuildStatistics& l = result.statistics.levels[level];
    printResult("%5zu  %7zu  %19.6g", level, l.spheres, l.overhang_bound_mm);
    if (shows_growth) printResult("  %24.4g", l.largest_growth_mm);
    printResult("\n");
  }
  if (options.lower_bound)
    printResult("proven: %g mm needs at least %zu spheres; this tree has %.2f times as many\n", options.settings.tolerance_mm,
                least_spheres, static_cast<double>(result.statistics.levels.back().spheres) / static_cast<double>(least_spheres));
  if (const Hulls& hulls = result.tree.hulls; !hulls.empty())
    printResult("hulls: %u in %zu parts, overhang bound %.6g mm\n", hulls.count, hulls.parts.size(), double{hulls.overhang_bound});
}

/// The largest number of leaves that the levels and children of the tree allow.
std::size_t leavesOf(const builder::BuildSettings& settings) {
  std::size_t allowed = 1;
  for (int level = 1; level < settings.levels; ++level) allowed *= static_cast<std::size_t>(settings.branching);
  return allowed;
}

/// Whether --leaves limits the number of leaves, instead of the size of the tree.
bool leavesBind(const builder::BuildSettings& settings) {
  return settings.max_leaves > 0 && static_cast<std::size_t>(settings.max_leaves) <= leavesOf(settings);
}

std::string leavesNote(const builder::BuildSettings& settings) {
  return "--leaves " + std::to_string(settings.max_leaves) + " has no effect: " + std::to_string(settings.levels) + " levels with " +
         std::to_string(settings.branching) + " children for each node allow " + counted(leavesOf(settings), "leaf", "leaves") +
         ". For more, add --levels.";
}

/// Parses a length above 0; empty for any other text.
std::optional<double> lengthIn(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool fits = error == std::errc() && end == text.data() + text.size() && std::isfinite(value) && value > 0;
  return fits ? std::optional<double>(value) : std::nullopt;
}

/// The trees to build: one mesh to the output file, or several meshes, each to its own file in the output folder.
std::vector<BuildOptions> treesOf(const BuildOptions& options) {
  std::vector<BuildOptions> trees;
  std::error_code none;
  const bool to_folder =
      options.inputs.size() > 1 || (endingOf(options.output) != ".stree" && std::filesystem::is_directory(options.output, none));
  if (to_folder && !options.report.empty()) throw UsageError("--report is for one tree. Leave it out, or name a file with -o.");
  if (to_folder && endingOf(options.output) == ".stree" && !std::filesystem::is_directory(options.output, none))
    throw UsageError(options.output.string() + ": several meshes need a folder. Name one with -o.");
  for (const std::filesystem::path& input : options.inputs) {
    trees.push_back(options);
    trees.back().input = input;
    if (!to_folder) continue;
    if (isDash(input)) throw UsageError("a mesh from standard input has no name for a file in a folder. Name a file with -o.");
    trees.back().output = options.output / input.stem().concat(".stree");
  }
  return trees;
}

/// What the texts of the options mean for the settings.
void settle(BuildOptions& options) {
  options.settings.builder = pipeline::byName(pipeline::kBuilders, options.builder);
  options.settings.skin = options.skin != "off";
  options.settings.skin_tolerance_mm = lengthIn(options.skin).value_or(0);
  if (options.shape == "hulls") {
    // The tolerance is that of the hulls. The balls beside them are as tight as the tree allows.
    options.settings.hulls = true;
    options.settings.hull_tolerance_mm = std::exchange(options.settings.tolerance_mm, 0);
    if (options.settings.max_leaves > 0) options.settings.max_hulls = std::min(options.settings.max_leaves, 4096);
    if (options.settings.skin_tolerance_mm == 0) options.settings.skin_tolerance_mm = options.settings.hull_tolerance_mm;
  }
  options.settings.quality = pipeline::byName(pipeline::kQualities, options.quality);
  options.settings.medial_axis = pipeline::byName(pipeline::kMedialAxes, options.medial_axis);
  if (options.settings.builder == BuilderKind::Combined && options.combine.empty()) options.combine = {"expand", "merge", "burst"};
  for (const std::string& member : options.combine) options.settings.combine.push_back(pipeline::byName(pipeline::kMembers, member));
}

int buildOne(BuildOptions options, bool quiet, builder::Progress& progress) {
  settle(options);
  // Also of what precedes the build; results do not depend on it.
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(builder::usefulThreads(options.settings.threads)));
  Stages own;
  auto begun = std::chrono::steady_clock::now();
  const auto finish = [&](const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    own.push_back({stage, std::chrono::duration<double>(now - begun).count()});
    begun = now;
  };
  progress.stage("read");
  formats::MeshFile file = pipeline::readMeshIn(options.input, options.unit);
  options.settings.unit_mm = file.unit_mm;
  const TriangleMesh mesh = pipeline::choosePart(std::move(file.mesh), options.parts);
  std::vector<std::string> notes = std::move(file.notes);
  progress.check();
  finish("read");
  progress.stage("check");
  const builder::RepairedMesh repaired =
      pipeline::soundMesh(mesh, options.input.string(), pipeline::repairKind(options.repair), notes, progress);
  finish(repaired.steps.empty() ? "check" : "repair");
  if (options.settings.max_leaves > 0 && !leavesBind(options.settings)) notes.push_back(leavesNote(options.settings));
  if (!quiet)
    for (const std::string& note : notes) say(formats::shownName(options.input) + ": " + note);
  progress.check();

  const builder::BuildResult result = builder::buildSphereTree(repaired.mesh, options.settings, progress, repaired.to_cover);
  progress.check();
  for (const std::string& note : result.statistics.notes) {
    notes.push_back(note);
    if (!quiet) say(formats::shownName(options.input) + ": " + note);
  }
  begun = std::chrono::steady_clock::now();
  formats::writeSphereTree(options.output, result.tree);
  if (!options.uncertified.empty()) formats::writeWhole(options.uncertified, formats::writeSph(result.uncertified, SphereKind::Cover));
  finish("write");
  std::size_t least_spheres = 0;
  if (options.lower_bound) {
    progress.stage("lower bound");
    least_spheres = builder::leastSpheres(repaired.mesh, options.settings.tolerance_mm, result.statistics.levels.back().spheres,
                                          options.settings.seed, progress, repaired.to_cover);
    finish("lower bound");
  }
  const Stages stages = allStages(own, result.statistics);
  if (!options.report.empty())
    formats::writeWhole(options.report, jsonText(reportOf(options, repaired, result, notes, least_spheres, stages), 2) + "\n");
  if (!isDash(options.output) && !isDash(options.report)) printSummary(options, result, least_spheres, stages);
  if (options.settings.tolerance_mm > 0 && !result.statistics.tolerance_met) {
    const std::string more = leavesBind(options.settings) ? "--leaves" : "--levels";
    const auto& leaves = result.statistics.levels.back();
    return explain(kProgram, kExitTargetMissed,
                   pipeline::missedTolerance(options.settings.tolerance_mm, leaves.overhang_bound_mm, leaves.spheres) + " Allow more " +
                       more + " or a larger --tolerance.");
  }
  return kExitOk;
}

/// If one of several meshes cannot be built, the others still are.
int runBuild(const BuildOptions& options, bool quiet, builder::Progress& progress) {
  const RunFiles files;
  const std::vector<BuildOptions> trees = treesOf(options);
  if (trees.size() > 1) files.makeFolder(options.output);
  for (const BuildOptions& tree : trees) {
    checkOptions(tree, files);
    if (tree.output != options.output) files.keepEdits(tree.output);  // named by its mesh
  }
  if (trees.size() == 1) return buildOne(trees[0], quiet, progress);
  int code = kExitOk;
  for (const BuildOptions& tree : trees) {
    try {
      if (buildOne(tree, quiet, progress) == kExitTargetMissed && code == kExitOk) code = kExitTargetMissed;
    } catch (const formats::FileError& error) {
      code = explain(kProgram, kExitPartlyFailed, error.what());
    } catch (const formats::FormatError& error) {
      code = explain(kProgram, kExitPartlyFailed, error.what());
    } catch (const builder::BuildError& error) {
      code = explain(kProgram, kExitPartlyFailed, error.what());
    }
  }
  return code;
}

/// What a tool rests on, and what a tool is.
void addContactOptions(CLI::App& app, const std::shared_ptr<BuildOptions>& options) {
  app.add_option("--shape", options->shape,
                 "hulls: also convex hulls of one, two or three balls, with which a tool is felt as smooth: the fewest that meet "
                 "--tolerance, or else the tightest --leaves; balls: balls alone; default balls")
      ->type_name("NAME")
      ->check(CLI::IsMember({"balls", "hulls"}));
  app.add_option("--skin", options->skin,
                 "Largest distance in mm between the skin (the surface that a tool rests on) and the mesh, above 0; auto: the tolerance, "
                 "or 0.2 % of the diagonal without one; off: no skin; default auto")
      ->type_name("MM")
      ->check([](const std::string& text) {
        const bool fits = text == "auto" || text == "off" || lengthIn(text);
        return fits ? std::string() : text + " is neither a length above 0 nor auto nor off";
      });
  app.add_option("--crease-angle", options->settings.crease_angle_deg,
                 "An edge of the mesh whose two triangles meet at a larger angle than this, in degrees, stays sharp on the skin; 1 to "
                 "180; default 50")
      ->type_name("DEG")
      ->check(numberIn(1, 180))
      ->each([options](const std::string&) { options->crease_angle_is_given = true; });
}

void addMethodOptions(CLI::App& app, const std::shared_ptr<BuildOptions>& options) {
  app.option_defaults()->group("Published methods");
  app.add_option("--builder", options->builder, "cover, combined, merge, burst, expand, spawn, grid, hubbard or octree; default cover")
      ->type_name("NAME")
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kBuilders)));
  app.add_option("--combine", options->combine,
                 "Reducers of --builder combined, separated by commas, of merge, burst, expand, spawn, grid and hubbard; default "
                 "expand,merge,burst")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false)  // otherwise it would take INPUT as a member
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kMembers)));
  app.add_flag("--search", options->settings.search,
               "The cover search distributes the balls of the published builder and adds balls where fewer than allowed are used; default: "
               "off, the tree is that of the method");
  app.add_option("--medial-axis", options->medial_axis,
                 "adaptive: the medial axis is refined where the spheres need it; static: Voronoi vertices of a fixed sample; for "
                 "builders merge, burst, expand and combined; default adaptive")
      ->type_name("KIND")
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kMedialAxes)));
  app.add_option("--uncertified", options->uncertified,
                 "Also write the spheres of a published method before certification made them cover the surface, as text of the "
                 "Sphere-Tree Construction Toolkit (.sph), to compare with its program; default: none")
      ->type_name("FILE");
}

}  // namespace

void addBuildCommand(Program& program) {
  const auto options = std::make_shared<BuildOptions>();
  CLI::App* app = addVerb(program, "build", "Build a certified sphere-tree of a closed triangle mesh",
                          "spheretree build tooth.obj -o tooth.stree --tolerance 0.1",
                          [options, &program](builder::Progress& progress) { return runBuild(*options, program.quiet, progress); });
  app->add_option("INPUT", options->inputs, "Meshes to read: .obj, .stl, .ply, .off, .gltf or .glb")->required()->type_name("FILE...");
  app->add_option("-o,--output", options->output, "Tree to write (.stree); with several meshes a folder, with NAME.stree for each")
      ->required()
      ->type_name("FILE|DIR");
  app->add_option("--quality", options->quality, "quick, standard or best: a slower build gives a tighter tree; default standard")
      ->type_name("NAME")
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kQualities)));
  app->add_option("--tolerance", options->settings.tolerance_mm,
                  "Largest overhang of the leaves in mm, above 0; the tree with the fewest spheres that meets it is built; default: none, "
                  "all levels are filled")
      ->type_name("MM")
      ->check([](const std::string& text) { return lengthIn(text) ? std::string() : text + " is not a length above 0"; });
  app->add_flag("--lower-bound", options->lower_bound,
                "With --tolerance: also prove how many spheres it needs at least; a minute or more for 512 leaves; default: off");
  addTreeSize(*app, options->settings.levels, options->settings.branching);
  app->add_option("--leaves", options->settings.max_leaves,
                  "Largest number of leaves, 1 to 32768; builder cover, or --search; default: as many as --levels and --branching allow")
      ->type_name("N")
      ->check(CLI::Range(1, 32768));
  addContactOptions(*app, options);
  app->add_option("--soft", options->settings.soft_share,
                  "Leaves for soft tissue, near the surface: their radii are at most this share of the local thickness, 0.05 to 0.5; "
                  "builder cover only; see docs/tissue.md. Such a tree needs more leaves: add --levels 5")
      ->type_name("SHARE")
      ->check(numberIn(0.05, 0.5));
  addUnit(*app, options->unit);
  app->add_option("--repair", options->repair,
                  "What to do with a defective mesh: auto: repair it with the smallest change that makes it sound; off: refuse it; wrap: "
                  "replace it by a closed surface around it; default auto")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "off", "wrap"}));
  addParts(*app, options->parts);
  app->add_flag("!--no-simplify", options->settings.simplify,
                "Search on every triangle. Default: off; for a mesh with more than 40,000 triangles and more than 400 for each possible "
                "leaf, the search uses a simplified mesh. The result is always proven against every triangle");
  addSeed(*app, options->settings.seed, "all random choices");
  addThreads(*app, options->settings.threads);
  app->add_option("--report", options->report, "Also write the settings, hashes, figures of each level and seconds as JSON; default: none")
      ->type_name("FILE");
  addForce(*app, program);
  addMethodOptions(*app, options);
}

}  // namespace spheretree::tool
