// SPDX-License-Identifier: GPL-3.0-or-later
// spheretree robot: spheres that cover the links of a URDF, in the formats of planners and simulators. docs/robots.md
#include <charconv>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "mistyped.h"
#include "options/command.h"
#include "options/common_options.h"
#include "options/robot_options.h"
#include "pipeline/builder_names.h"
#include "pipeline/sound_mesh.h"
#include "robot/cover/ignored_pairs.h"
#include "robot/cover/robot_cover.h"
#include "robot/files/robot_files.h"
#include "run_files.h"
#include "spheretree/formats/file_io.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

namespace fs = std::filesystem;

struct RobotOptions {
  robot::RobotInput input;
  fs::path folder, srdf, merge;
  std::vector<std::string> links, clip;
  std::string quality = "standard", repair = "auto";
  std::size_t budget = 0;
  robot::CoverSettings settings;
};

/// Parses "PATTERN=N".
std::optional<robot::LinkCount> linkCount(const std::string& text) {
  const std::size_t at = text.rfind('=');
  robot::LinkCount count;
  if (at == std::string::npos || at == 0) return std::nullopt;
  count.pattern = text.substr(0, at);
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + at + 1, end, count.spheres);
  return error == std::errc() && stop == end && count.spheres >= 1 && count.spheres <= 4096 ? std::optional(count) : std::nullopt;
}

/// Parses triples of LINK, an axis (x, -z, ...) and a value in mm.
std::vector<robot::ClipPlane> clipPlanes(const std::vector<std::string>& words) {
  std::vector<robot::ClipPlane> planes;
  for (std::size_t i = 0; i + 2 < words.size(); i += 3) {
    robot::ClipPlane plane{words[i], Eigen::Vector3d::Zero(), 0};
    const std::string& axis = words[i + 1];
    const std::size_t letter = axis.size() == 2 && axis[0] == '-' ? 1 : 0;
    const std::size_t which = axis.size() == letter + 1 ? std::string("xyz").find(axis[letter]) : std::string::npos;
    if (which == std::string::npos) throw UsageError("--clip " + words[i] + " " + axis + ": the axis is not x, y, z, -x, -y or -z.");
    plane.axis[static_cast<Eigen::Index>(which)] = letter == 1 ? -1 : 1;
    const std::string& value = words[i + 2];
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), plane.value);
    if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(plane.value))
      throw UsageError("--clip " + words[i] + " " + axis + " " + value + ": the value is not a length in mm.");
    planes.push_back(plane);
  }
  return planes;
}

void printLinks(const RobotOptions& options, const robot::Robot& robot, const robot::RobotCover& cover,
                const std::vector<robot::IgnoredPair>& pairs, double seconds) {
  std::size_t widest = 4;
  for (const robot::LinkCover& link : cover.links) widest = std::max(widest, robot.links[link.link].name.size());
  const int width = static_cast<int>(std::min<std::size_t>(widest, 60));
  printResult("%-*s  spheres  overhang bound [mm]\n", width, "link");
  for (const robot::LinkCover& link : cover.links)
    printResult("%-*s  %7zu  %19.6g%s\n", width, plainText(robot.links[link.link].name).c_str(), link.spheres().size(),
                link.overhangBound(), link.is_clipped ? "  clipped: not covered at and beyond the plane" : "");
  std::size_t adjacent = 0, always = 0;
  for (const robot::IgnoredPair& pair : pairs) {
    adjacent += pair.reason == robot::PairReason::Adjacent;
    always += pair.reason == robot::PairReason::Always;
  }
  printResult("%s: %zu spheres on %s; every surface is covered; %.1f s\n", plainText(options.folder.string()).c_str(), cover.sphereCount(),
              counted(cover.links.size(), "link").c_str(), seconds);
  printResult("pairs of links to ignore: %zu adjacent, %zu that always touch, %zu proven never to touch within the joint limits\n",
              adjacent, always, pairs.size() - adjacent - always);
}

robot::CoverSettings settingsOf(const RobotOptions& options, const robot::Robot& robot) {
  robot::CoverSettings settings = options.settings;
  for (const std::string& text : options.links) settings.counts.push_back(*linkCount(text));
  settings.clips = clipPlanes(options.clip);
  settings.quality = pipeline::byName(pipeline::kQualities, options.quality);
  settings.repair = pipeline::repairKind(options.repair);
  settings.budget = options.budget;
  if (settings.tolerance_mm > 0 || settings.budget > 0) return settings;
  settings.budget = robot::usualBudget(robot);
  return settings;
}

int runRobot(const RobotOptions& options, bool quiet, builder::Progress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  const RunFiles files(progress);
  for (const fs::path& input : {options.input.urdf, options.srdf, options.merge})
    if (!input.empty()) files.willRead(input);
  progress.stage("read");
  auto [robot, shapes] = robot::readRobot(options.input, progress);
  const robot::CoverSettings settings = settingsOf(options, robot);
  robot::makeRobotFolders(options.folder, files);
  for (const fs::path& name : robot::robotFileNames(robot)) files.willMake(options.folder / name);
  const std::vector<std::string> file_notes = robot::robotFiles({robot, {}, {}, options.srdf, options.merge}, options.folder).notes;
  if (!quiet)
    for (const std::vector<std::string>* notes : {&std::as_const(robot.notes), &file_notes})
      for (const std::string& note : *notes) say(note);

  const robot::RobotCover cover = robot::coverRobot(robot, std::move(shapes), settings, progress);
  const std::vector<robot::IgnoredPair> pairs = robot::findIgnoredPairs(robot, cover, {}, progress);
  progress.stage("write");
  progress.check();
  robot::writeRobotFiles({robot, cover, pairs, options.srdf, options.merge}, options.folder);

  bool is_met = true;
  for (const robot::LinkCover& link : cover.links) {
    is_met = is_met && (!(settings.tolerance_mm > 0) || link.overhangBound() <= settings.tolerance_mm || link.is_clipped);
    if (!quiet)
      for (const std::string& note : link.notes) say(note);
  }
  if (!quiet && options.merge.empty())
    say("XRDF and cuRobo need limits of acceleration and jerk, which a URDF does not hold. Take them from a file: --merge FILE.xrdf or "
        "FILE.yml.");
  printLinks(options, robot, cover, pairs, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  if (!is_met && settings.counts.empty())
    return explain(kProgram, kExitTargetMissed,
                   "the tolerance is not met everywhere; the best result was written. Allow a larger --tolerance.");
  return kExitOk;
}

}  // namespace

void addRobotCommand(Program& program) {
  const auto options = std::make_shared<RobotOptions>();
  CLI::App* app = addVerb(program, "robot", "Spheres for a robot: cover the collision shapes of a URDF, for planners and simulators",
                          "spheretree robot panda.urdf -o panda --budget 60 --links hand=8",
                          [options, &program](builder::Progress& progress) { return runRobot(*options, program.quiet, progress); });
  app->add_option("URDF", options->input.urdf, "Robot to read (.urdf, xacro expanded). Meshes: STL, OBJ, PLY, OFF, glTF, DAE")
      ->required()
      ->type_name("FILE");
  app->add_option("-o,--output", options->folder,
                  "Folder for the files of cuRobo, XRDF, URDF, SRDF, VAMP, foam, ballpark, MorphIt and MJCF; created if it is missing")
      ->required()
      ->type_name("DIR");
  CLI::Option* tolerance = app->add_option("--tolerance", options->settings.tolerance_mm,
                                           "Largest overhang of the spheres of each shape in mm, above 0, with the fewest spheres that "
                                           "meet it; default: none, --budget sets their number")
                               ->type_name("MM")
                               ->check(numberIn(1e-9, 1e6));
  app->add_option("--budget", options->budget,
                  "Number of spheres of all links together, 1 to 100000, shared so that the largest error is as small as possible; default "
                  "8 for each collision element")
      ->type_name("N")
      ->check(CLI::Range(1, 100000))
      ->excludes(tolerance);
  app->add_option("--links", options->links,
                  "PATTERN=N, several separated by commas: N spheres, 1 to 4096, for each link whose name matches (* any text, ? any "
                  "letter); --budget and --tolerance then apply to the other links; the first pattern that matches is used; default: none")
      ->type_name("LIST")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check([](const std::string& text) { return linkCount(text) ? std::string() : text + " is not PATTERN=N with N from 1 to 4096"; });
  app->add_option("--clip", options->clip,
                  "LINK AXIS VALUE: no sphere of the link reaches below VALUE mm along AXIS (x, y, z, -x, -y or -z) of its frame, for "
                  "example for a base on a table; may be given again; default: none")
      ->type_name("LINK AXIS VALUE")
      ->type_size(3)
      ->allow_extra_args(false);
  app->add_option("--srdf", options->srdf, "SRDF whose groups, states and pairs are copied into the written SRDF; default: none")
      ->type_name("FILE");
  app->add_option(
         "--merge", options->merge,
         "XRDF or configuration of cuRobo (.yml) whose limits, tool frames and other keys are copied into the written files; default: none")
      ->type_name("FILE");
  addRobotInput(*app, options->input);
  app->add_option("--unit", options->input.units,
                  "Unit of the numbers in the mesh files: mm, cm, m or in, or PATTERN=UNIT for the links whose name matches, several "
                  "separated by commas; the first pattern that matches is used; default m")
      ->type_name("UNIT")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(unitFault);
  app->add_option("--quality", options->quality, "quick, standard or best; default standard")
      ->type_name("NAME")
      ->check(CLI::IsMember(pipeline::namesOf(pipeline::kQualities)));
  app->add_option("--repair", options->repair, "Repair of the meshes, as in build: auto, off or wrap; default auto")
      ->type_name("KIND")
      ->check(CLI::IsMember({"auto", "off", "wrap"}));
  addSeed(*app, options->settings.seed, "all random choices");
  addThreads(*app, options->settings.threads);
  addForce(*app, program);
}

}  // namespace spheretree::tool
