// SPDX-License-Identifier: GPL-3.0-or-later
#include "commands/evaluate/evaluate_robot.h"

#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "json_text.h"
#include "options/command.h"
#include "pipeline/evaluation_json.h"
#include "pipeline/sound_mesh.h"
#include "robot/files/sphere_file.h"
#include "robot/model/link_shape.h"
#include "run_files.h"
#include "spheretree/formats/errors.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

using Json = nlohmann::ordered_json;

struct Row {
  std::string link;
  std::size_t spheres = 0;
  std::optional<builder::Evaluation> evaluation;  // empty without spheres
};

Row evaluateLink(const EvaluateRobotOptions& options, const robot::Link& link, std::span<const robot::ShapedElement> elements,
                 const robot::SphereFile& spheres, bool quiet, builder::Progress& progress) {
  Row row{link.name, 0, std::nullopt};
  for (const robot::SphereSet& set : spheres.sets) {
    if (set.link != link.name && !(set.link.empty() && !options.link.empty())) continue;
    const builder::RepairedMesh solid = builder::repairMesh(robot::meshOf(elements), pipeline::repairKind(options.repair), progress);
    if (!quiet && !solid.isSound())
      say("spheretree: warning: " + link.name + " is not a closed, clean surface, so that inside and outside are uncertain.");
    progress.check();
    row.spheres = set.balls.size();
    row.evaluation = builder::evaluateTree(solid.mesh, robot::levelOf(set), options.settings, progress, solid.to_cover);
  }
  return row;
}

void printRows(const std::vector<Row>& rows) {
  std::size_t widest = 4;
  for (const Row& row : rows) widest = std::max(widest, row.link.size());
  const int width = static_cast<int>(std::min<std::size_t>(widest, 60));
  printResult("%-*s  spheres  uncovered [%%]  max gap [mm]  overhang max [mm]  excess volume [%%]\n", width, "link");
  for (const Row& row : rows) {
    const std::string name = plainText(row.link);
    if (!row.evaluation) {
      printResult("%-*s  %7d  %13.4f  %12s  %17s  %17s\n", width, name.c_str(), 0, 100.0, "-", "-", "-");
      continue;
    }
    const builder::LevelEvaluation& level = row.evaluation->levels.back();
    printResult("%-*s  %7zu  %13.4f  %12.5g  %17.5g  %17.4f\n", width, name.c_str(), row.spheres, 100 * level.coverage.uncovered_fraction,
                level.coverage.max_gap, level.overhang.max, 100 * level.excess_volume_fraction);
  }
}

}  // namespace

int evaluateRobot(const EvaluateRobotOptions& options, bool quiet, builder::Progress& progress) {
  const auto [robot, shapes] = robot::readRobot(options.input, progress);
  if (!quiet)
    for (const std::string& note : robot.notes) say(note);
  const robot::SphereFile spheres = robot::readSphereFile(options.spheres, options.sphere_unit_mm);
  if (!quiet && spheres.without_volume > 0)
    say(options.spheres.string() + ": " + counted(spheres.without_volume, "sphere") + " with a radius of 0 or below left out.");
  std::vector<Row> rows;
  for (const std::span<const robot::ShapedElement> elements : robot::linksOf(shapes)) {
    const robot::Link& link = robot.links[elements.front().link];
    if (!options.link.empty() && link.name != options.link) continue;
    progress.stage(link.name);
    rows.push_back(evaluateLink(options, link, elements, spheres, quiet, progress));
  }
  if (rows.empty()) throw formats::FormatError(options.input.urdf.string() + ": has no link named " + options.link + " with a shape.");
  if (!options.json) {
    printRows(rows);
    return kExitOk;
  }
  Json out{{"schema", "spheretree.robot_evaluation/1"}, {"format", spheres.format}, {"links", Json::array()}};
  for (const Row& row : rows)
    out["links"].push_back({{"link", row.link},
                            {"spheres", row.spheres},
                            {"diagonal_mm", row.evaluation ? Json(row.evaluation->diagonal) : Json(nullptr)},
                            {"level", row.evaluation ? pipeline::levelJson(row.evaluation->levels.back()) : Json(nullptr)}});
  writeResult(jsonText(out, 2) + "\n");
  return kExitOk;
}

}  // namespace spheretree::tool
