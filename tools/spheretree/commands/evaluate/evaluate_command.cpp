// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree evaluate: how well a tree represents a mesh. Definition of the figures: docs/measures.md
#include <Eigen/Geometry>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "commands/evaluate/evaluate_robot.h"
#include "commands/evaluate/evaluate_states_report.h"
#include "input/tree_input.h"
#include "json_text.h"
#include "options/command.h"
#include "options/common_options.h"
#include "options/robot_options.h"
#include "pipeline/evaluation_json.h"
#include "pipeline/part_choice.h"
#include "pipeline/sound_mesh.h"
#include "robot/files/sphere_file.h"
#include "run_files.h"
#include "spheretree/builder/evaluate_tree.h"
#include "spheretree/builder/provenance.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/mesh_file.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

struct EvaluateOptions {
  std::filesystem::path mesh, tree;
  std::string parts = "merge", repair = "auto";
  bool json = false, no_limits = false;
  builder::EvaluateSettings settings;
  StatesOptions states;
  std::string link, spheres_unit;  // of a file of spheres; unit "": as the file states it, or metres
  robot::RobotInput robot;         // `units` also holds the unit of another mesh
};

void printProven(const builder::LevelEvaluation& leaves, const builder::ProvenLimit& proven, double percent) {
  if (!(proven.overhang > 0)) return printResult("proven: nothing about the best possible overhang for %zu spheres\n", leaves.spheres);
  printResult("proven: no cover of %zu spheres has an overhang below %.5g mm (%.4f %% of D); this tree's bound is %.2f times that\n",
              leaves.spheres, proven.overhang, proven.overhang * percent, leaves.overhang.bound / proven.overhang);
}

void printText(const EvaluateOptions& options, std::size_t triangles, const builder::Evaluation& evaluation) {
  const double percent = 100 / evaluation.diagonal;
  printResult("%s against %s: %zu triangles, diagonal D = %.6g mm\n\n", plainText(formats::shownName(options.tree)).c_str(),
              plainText(formats::shownName(options.mesh)).c_str(), triangles, evaluation.diagonal);
  printResult("               overhang [mm]                                overhang [%% of D]\n");
  printResult("level  spheres        max      bound        p99       mean       max    bound      p99     mean\n");
  for (const builder::LevelEvaluation& level : evaluation.levels) {
    const builder::Overhang& o = level.overhang;
    printResult("%5d  %7zu  %9.5g  %9.5g  %9.5g  %9.5g  %8.4f %8.4f %8.4f %8.4f\n", level.level, level.spheres, o.max, o.bound, o.p99,
                o.mean, o.max * percent, o.bound * percent, o.p99 * percent, o.mean * percent);
  }
  printResult("\nlevel  uncovered [%%]  max gap [mm]  max gap [%% of D]  excess volume [%%]  missing volume [%%]\n");
  for (const builder::LevelEvaluation& level : evaluation.levels)
    printResult("%5d  %13.4f  %12.5g  %16.4f  %17.4f  %18.4f\n", level.level, 100 * level.coverage.uncovered_fraction,
                level.coverage.max_gap, level.coverage.max_gap * percent, 100 * level.excess_volume_fraction,
                100 * level.missing_volume_fraction);
  const builder::HierarchyEvaluation& hierarchy = evaluation.hierarchy;
  printResult("\n%zu leaves; %zu reach out of the bounding sphere of an ancestor, %zu out of the cover sphere of an ancestor\n",
              hierarchy.leaves, hierarchy.leaves_outside_ancestor, hierarchy.leaves_outside_ancestor_cover);
  if (evaluation.skin && evaluation.skin->from_mesh)
    printResult("skin: %zu triangles, at most %.3g mm from the mesh, the mesh %.3g mm from them; patches at most %.3g mm from them\n",
                evaluation.skin->triangles, *evaluation.skin->from_mesh, *evaluation.skin->of_mesh, evaluation.skin->tolerance);
  if (evaluation.hulls) {
    const builder::HullEvaluation& hulls = *evaluation.hulls;
    printResult("hulls: %zu in %zu parts of %zu balls; overhang max %.5g mm, bound %.5g mm; %zu of %zu surface points bare", hulls.hulls,
                hulls.parts, hulls.balls, hulls.overhang_max, hulls.overhang_bound, hulls.bare_samples, hulls.samples);
    printResult(hulls.bare_samples > 0 ? ", at most %.5g mm outside\n" : "\n", hulls.max_gap);
  }
  if (evaluation.proven) printProven(evaluation.levels.back(), *evaluation.proven, percent);
  if (!evaluation.limits) return;
  const builder::CoverLimits& limits = *evaluation.limits;
  const builder::LevelEvaluation& leaves = evaluation.levels.back();
  const auto line = [&](const char* name, double limit, const char* note) {
    printResult("%s = %.5g mm (%.4f %% of D)%s", name, limit, limit * percent, note);
    if (limit > 0) printResult("; overhang max is %.2f times that", leaves.overhang.max / limit);
    printResult("\n");
  };
  printResult("limits for %zu spheres that cover the surface:\n", leaves.spheres);
  line("  h_fin", limits.h_fin, "");
  line("  h_low", limits.h_low, limits.h_low_in_range ? "" : " (end of the range)");
}

/// A tree, or the spheres of one link as one level.
SphereTree readTreeOrSpheres(const EvaluateOptions& options) {
  if (isDash(options.tree) || !robot::isSphereFile(options.tree)) {
    if (!options.link.empty())
      throw UsageError("--link is for a file of spheres with links. " + options.tree.string() + " is a tree. Leave it out.");
    return readTree(options.tree);
  }
  const robot::SphereFile file = robot::readSphereFile(options.tree, spheresUnit(options.spheres_unit));
  return robot::levelOf(robot::setOf(file, options.tree, options.link));
}

Eigen::AlignedBox3d boxOf(const SphereTree& tree) {
  Eigen::AlignedBox3d box;
  for (const Sphere& s : tree.cover) {
    const Eigen::Vector3d centre(double{s.x} + tree.origin_mm[0], double{s.y} + tree.origin_mm[1], double{s.z} + tree.origin_mm[2]);
    box.extend(centre - Eigen::Vector3d::Constant(s.radius)), box.extend(centre + Eigen::Vector3d::Constant(s.radius));
  }
  return box;
}

/// A warning if spheres are of quite another size than their mesh, with the option that mends it.
std::string sizeWarning(const EvaluateOptions& options, const TriangleMesh& mesh, const SphereTree& tree) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : mesh.positions) box.extend(p);
  const double ratio = boxOf(tree).diagonal().norm() / box.diagonal().norm();
  if (!(ratio > 5 || ratio < 0.2)) return {};
  char text[160];
  std::snprintf(text, sizeof text, "the spheres are %.3g times as large as the mesh", ratio);
  std::string fitting;
  const double read = spheresUnit(options.spheres_unit).value_or(1000);
  for (const char* unit : {"mm", "cm", "in", "m"})
    if (const double scaled = ratio * formats::unitInMm(unit) / read; scaled > 0.5 && scaled < 2)
      fitting = std::string(": --spheres-unit ") + unit + " makes them fit";
  return text + (robot::isSphereFile(options.tree) ? fitting : "") + ".";
}

int runEvaluate(EvaluateOptions options, const Program& program, builder::Progress& progress) {
  const RunFiles files;
  files.willRead(options.mesh);
  files.willRead(options.tree);
  progress.stage("read");
  if (endingOf(options.mesh) == ".urdf") {
    options.settings.limits = false;
    options.robot.urdf = options.mesh;
    return evaluateRobot(
        {options.robot, options.tree, options.link, spheresUnit(options.spheres_unit), options.repair, options.json, options.settings},
        program.quiet, progress);
  }
  const std::string unit = options.robot.units.empty() ? "" : options.robot.units.front();
  if (options.robot.units.size() > 1 || unit.find('=') != std::string::npos || options.robot.is_visual || !options.robot.packages.empty())
    throw UsageError("PATTERN=UNIT, --visual and --package are for a robot (.urdf). " + options.mesh.string() + " is a mesh.");
  Tissue tissue;
  const SphereTree tree = options.states.states.empty() ? readTreeOrSpheres(options) : readSoftTree(options.tree, tissue);
  formats::MeshFile file = pipeline::readMeshIn(options.mesh, unit);
  TriangleMesh mesh = pipeline::choosePart(std::move(file.mesh), options.parts);
  progress.check();
  // The same solid that a build uses.
  const builder::RepairedMesh repaired = builder::repairMesh(mesh, pipeline::repairKind(options.repair), progress);
  if (!program.quiet) {
    for (const builder::RepairStep& step : repaired.steps) say(formats::shownName(options.mesh) + ": " + step.text);
    if (!repaired.isSound())
      say("spheretree: warning: " + formats::shownName(options.mesh) +
          " is not a closed, clean surface, so that inside and outside are uncertain; `spheretree check` says where.");
  }
  progress.check();
  if (!options.states.states.empty()) {
    options.states.json = options.json, options.states.seed = options.settings.seed, options.states.threads = options.settings.threads;
    return reportStates(formats::shownName(options.tree), tree, tissue, repaired, options.states, progress);
  }
  mesh = repaired.mesh;
  if (const std::string warning = sizeWarning(options, mesh, tree); !program.quiet && !warning.empty())
    say("spheretree: warning: " + warning);
  if (const std::string warning = otherMeshWarning(tree, options.tree, mesh, options.mesh); !program.quiet && !warning.empty())
    say("spheretree: warning: " + warning);
  options.settings.limits = !options.no_limits;
  builder::Evaluation evaluation;
  try {
    evaluation = builder::evaluateTree(mesh, tree, options.settings, progress, repaired.to_cover);
  } catch (const std::invalid_argument& error) {  // a mesh without area: readers accept it, but nothing can be measured on it
    throw formats::FormatError(options.mesh.string() + ": " + error.what() + ". Export it again.");
  }
  if (options.json)
    writeResult(jsonText(pipeline::evaluationJson(evaluation), 2) + "\n");
  else
    printText(options, mesh.triangles.size(), evaluation);
  return kExitOk;
}

}  // namespace

void addEvaluateCommand(Program& program) {
  const auto options = std::make_shared<EvaluateOptions>();
  CLI::App* app = addVerb(program, "evaluate", "Measure how well every level of a tree approximates a mesh",
                          "spheretree evaluate tooth.obj tooth.stree --json",
                          [options, &program](builder::Progress& progress) { return runEvaluate(*options, program, progress); });
  app->add_option("MESH", options->mesh, "Mesh: .obj, .stl, .ply, .off, .gltf or .glb; or a robot (.urdf), link by link")
      ->required()
      ->type_name("FILE");
  app->add_option("TREE", options->tree,
                  "Tree: .stree, .soft, .sph or .json; or spheres as a list or of a robot: .csv, .yml, .xrdf, .json, .urdf, .srdf or .xml")
      ->required()
      ->type_name("FILE");
  app->add_option("--link", options->link, "Link, where a file of spheres has several; default: the only link; for a robot all links")
      ->type_name("NAME");
  addSpheresUnit(*app, options->spheres_unit);
  addRobotInput(*app, options->robot);
  app->add_flag("--json", options->json, "Print JSON on stdout, schema spheretree.evaluation/1");
  app->add_flag("--no-limits", options->no_limits, "Do not compute h_fin and h_low, which take about a third of the time; default: off");
  app->add_flag("--lower-bound", options->settings.lower_bound,
                "Prove how small the overhang of this number of spheres can be at best; a minute or more for 512 leaves; default: off");
  app->add_option(
         "--unit", options->robot.units,
         "Unit of the numbers in the mesh file: mm, cm, m or in; default mm, and m for glTF and the meshes of a robot. For a robot "
         "also PATTERN=UNIT, several separated by commas, for the links whose name matches")
      ->type_name("UNIT")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(unitFault);
  addParts(*app, options->parts);
  app->add_option("--repair", options->repair, "As for the build of the tree: auto, off or wrap; default auto")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "off", "wrap"}));
  app->add_option("--states", options->states.states,
                  "For a soft tree, in place of the levels: N deformed states (squeezed, poked, bent, noisy, inverted), or a file of "
                  "states (.csv); default: none")
      ->type_name("N|FILE");
  app->add_option("--samples", options->states.samples, "Surface points tested in each state, 100 to 1000000; default 10000")
      ->type_name("N")
      ->check(CLI::Range(100, kMaxStateSamples));
  addSeed(*app, options->settings.seed, "the surface points and of the states");
  addThreads(*app, options->settings.threads);
}

}  // namespace spheretree::tool
