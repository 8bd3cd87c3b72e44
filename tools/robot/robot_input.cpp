// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/robot_input.h"

#include "pipeline/json_file.h"
#include "robot/files/robot_files.h"
#include "spheretree/formats/errors.h"

namespace spheretree::robot {
namespace fs = std::filesystem;

RobotWithShapes readRobot(const RobotInput& input, const builder::Progress& progress) {
  std::vector<LinkUnit> units;
  for (const std::string& text : input.units) units.push_back(*linkUnit(text));
  RobotWithShapes out;
  out.robot = readUrdf(input.urdf, packagePaths(input.packages), input.is_visual ? ShapeSource::Visual : ShapeSource::Collision);
  out.shapes = readShapes(out.robot, units, progress);
  return out;
}

RobotManifest readManifest(const fs::path& path) {
  return pipeline::readJsonAs(path, kManifestSchema, [&](const nlohmann::ordered_json& json) {
    const fs::path folder = path.parent_path();
    const auto fromHere = [&](const std::string& name) { return (folder / fs::path(name)).lexically_normal().string(); };
    RobotManifest out;
    out.input.urdf = fromHere(json.at("urdf").get<std::string>());
    for (const std::string& word : json.at("packages").get<std::vector<std::string>>()) {
      std::error_code none;
      const std::size_t name = fs::is_directory(fromHere(word), none) ? 0 : word.find('=') + 1;  // 0: a folder without a name
      out.input.packages.push_back(word.substr(0, name) + fromHere(word.substr(name)));
    }
    out.input.units = json.at("units").get<std::vector<std::string>>();
    for (const std::string& unit : out.input.units)
      if (!linkUnit(unit)) throw formats::FormatError(path.string() + ": " + unit + " is not a unit. Run spheretree robot again.");
    out.input.is_visual = json.at("visual").get<bool>();
    out.spheres = fromHere(json.at("spheres").get<std::string>());
    out.figures = {
        {"robot", json.at("robot").get<std::string>()}, {"links", json.at("links")}, {"ignored_pairs", json.at("ignored_pairs")}};
    return out;
  });
}

}  // namespace spheretree::robot
