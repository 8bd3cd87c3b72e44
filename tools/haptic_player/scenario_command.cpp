// SPDX-License-Identifier: GPL-3.0-or-later
#include "scenario_command.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "comparison/comparison.h"
#include "comparison/cutting.h"
#include "comparison/tool_models.h"
#include "program_end.h"
#include "run/play.h"
#include "run_files.h"
#include "scenarios/stability.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"
#include "spheretree/formats/path_name.h"
#include "spheretree/formats/trajectory.h"
#include "spheretree/scene/describe_scene.h"
#include "terminal.h"
#include "view/run_view.h"

namespace spheretree::player {

using namespace spheretree::tool;

namespace {

/// The selection that a list of names means; an invalid list is a usage error.
template <class Choose>
auto chosen(Choose&& choose) {
  try {
    return choose();
  } catch (const std::invalid_argument& unknown) {
    throw UsageError(unknown.what());
  }
}

std::vector<CuttingRow> cuttingRows(const std::vector<CuttingCourse>& courses, double voxel, builder::Progress& progress) {
  std::vector<CuttingRow> rows;
  for (const CuttingCourse& course : courses) {
    progress.stage("cut, " + course.name);
    for (CuttingRow& row : compareCutting(course, voxel, progress)) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

int listScenarios() {
  for (const Scenario& s : scenarios()) printResult("%-4s %-12s %s\n", s.id.c_str(), s.alias.c_str(), s.title.c_str());
  return kExitOk;
}

int runScenarioCommand(const ScenarioOptions& options, double rate, runtime::ContactSurface contact, bool json, const ViewOptions& view,
                       WorkProgress& progress) try {
  const std::vector<const Scenario*> scenarios = chosen([&] { return selectScenarios(options.scenario); });
  const std::vector<Mode> modes = chosen([&] { return modesOf(options.modes); });
  if (!options.chart.empty()) RunFiles().willWrite(options.chart, {".html"}, "the page");
  if (!options.out.empty()) {  // checked now, not after minutes
    RunFiles().makeFolder(options.out);
    formats::checkWritable(options.out / "stability.json");
    RunFiles().keepOthers(options.out, [](const std::string& name) {
      return name == "stability.json" || std::ranges::count(std::array{".stree", ".off", ".csv"}, endingOf(name)) > 0;
    });
  }
  for (const Scenario* scenario : scenarios)
    if (rate != 1000 && !scenario->has_rate)
      throw UsageError("--rate is for the scenarios S1 and S3: " + scenario->id + " has steps of 1 ms. Name those, as --scenario S1,S3");
  const builder::Quality quality = options.quality == "quick" ? builder::Quality::Quick : builder::Quality::Standard;
  BodyLibrary bodies(quality, contact, progress, options.cache);
  ScenarioContext context{bodies, {options.share, options.turned, rate}, progress};
  if (view.isAsked()) {
    if (scenarios.size() != 1) throw UsageError("--view and --picture show one scenario. Name it, as --scenario F5");
    return viewScenario(view, *scenarios.front(), context, progress);
  }
  const int threads = options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  int short_of = 0;
  if (!json) writeResult(tableHead(modes));
  const std::vector<ScenarioResult> results =
      runScenarios(scenarios, context, {modes, options.out, threads}, progress, [&](const ScenarioResult& result) {
        short_of += !holds(result);
        if (!json) writeResult(tableRows(result, modes));
        std::fflush(stdout);
      });
  if (json)
    printResult("%s\n", stabilityJson(results, quality).dump(1).c_str());
  else
    printResult("%s, %d fall short in %s mode\n", counted(results.size(), "scenario").c_str(), short_of,
                std::count(modes.begin(), modes.end(), Mode::Constrained) > 0 ? "constrained" : "some");
  if (!options.out.empty()) writeStability(options.out, results, quality);
  if (!options.chart.empty())
    writeComparison(options.chart, compareRenderers(context, modes, progress), cuttingRows(cuttingBench(bodies), kVoxelEdge, progress),
                    results, modes);
  return short_of ? kExitTargetMissed : kExitOk;
} catch (const builder::Cancelled&) {
  if (options.out.empty()) throw;
  return explain("haptic-player", kExitInterrupted, "interrupted. The recordings of the scenarios that were finished are kept.");
}

int runCuttingCommand(const CuttingOptions& options, bool json, builder::Progress& progress) {
  if (options.scene.empty() != options.trajectory.empty())
    throw UsageError("--compare-cutting takes a scene and its --trajectory, or neither: then a block is cut");
  if (!options.chart.empty()) RunFiles().willWrite(options.chart, {".html"}, "the page");
  std::vector<CuttingCourse> courses;
  if (options.scene.empty()) {
    BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress, options.cache);
    courses = cuttingBench(bodies);
  } else {
    const std::filesystem::path scene = scene::sceneFileAt(options.scene);
    courses.push_back(
        {formats::toUtf8(options.trajectory.filename()), describeScene(scene, progress), formats::readTrajectory(options.trajectory)});
  }
  std::vector<CuttingRow> rows;
  try {
    rows = cuttingRows(courses, options.voxel, progress);
  } catch (const std::invalid_argument& fault) {
    throw formats::FormatError(formats::toUtf8(options.scene) + ": " + fault.what());
  }
  if (json)
    printResult("%s\n", cuttingJson(rows, options.voxel).dump(1).c_str());
  else
    writeResult(cuttingTable(rows));
  if (!options.chart.empty()) writeCuttingPage(options.chart, rows, options.voxel);
  return kExitOk;
}

int runToolsCommand(const ToolsOptions& options, bool json, WorkProgress& progress) {
  if (!options.chart.empty()) RunFiles().willWrite(options.chart, {".html"}, "the page");
  std::vector<std::string> names = options.names;
  if (names == std::vector<std::string>{"all"}) names.clear();
  progress.stage("paths of the hand");
  const std::vector<ToolCourse> courses = chosen([&] { return toolBench(names, options.depth, progress); });
  BodyLibrary bodies(builder::Quality::Quick, runtime::ContactSurface::Skin, progress, options.cache);
  const std::vector<ToolModel> models = toolModels();
  const std::vector<ToolRow> rows = compareTools(courses, models, bodies, progress);
  if (json)
    printResult("%s\n", toolJson(rows).dump(1).c_str());
  else
    writeResult(toolTable(rows));
  if (!options.chart.empty()) writeToolPage(options.chart, rows, options.depth);
  return kExitOk;
}

}  // namespace spheretree::player
