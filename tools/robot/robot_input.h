// SPDX-License-Identifier: GPL-3.0-or-later
// What a robot is read from, and the manifest by which a folder of results names it. Documentation: docs/robots.md
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "robot/model/robot_shapes.h"

namespace spheretree::robot {

struct RobotInput {
  std::filesystem::path urdf;
  std::vector<std::string> packages;  // FOLDER or NAME=FOLDER
  std::vector<std::string> units;     // UNIT or PATTERN=UNIT
  bool is_visual = false;
};

struct RobotWithShapes {
  Robot robot;
  std::vector<ShapedElement> shapes;
};

/// @throws those of packagePaths(), readUrdf() and readShapes()
RobotWithShapes readRobot(const RobotInput& input, const builder::Progress& progress);

struct RobotManifest {
  RobotInput input;
  std::filesystem::path spheres;   // a file in a format of readSphereFile()
  nlohmann::ordered_json figures;  // as in the file: "robot", "links" and "ignored_pairs"
};

/// @throws formats::FileError; formats::FormatError for anything else than a manifest
RobotManifest readManifest(const std::filesystem::path& path);

}  // namespace spheretree::robot
