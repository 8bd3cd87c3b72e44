// SPDX-License-Identifier: GPL-3.0-or-later
// The robot that a verb reads: its options, and the shapes of its links.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "robot/robot_shapes.h"

namespace spheretree::tool {

struct RobotInput {
  std::filesystem::path urdf;
  std::vector<std::string> packages;  // FOLDER or NAME=FOLDER
  std::vector<std::string> units;     // UNIT or PATTERN=UNIT
  bool is_visual = false;
};

struct RobotWithShapes {
  robot::Robot robot;
  std::vector<robot::ShapedElement> shapes;
};

/// --package and --visual.
void addRobotInput(CLI::App& app, RobotInput& input);

/// For a list of units: "" or what is wrong with the text.
std::string unitFault(const std::string& text);

/// @throws those of robot::packagePaths(), robot::readUrdf() and robot::readShapes()
RobotWithShapes readRobot(const RobotInput& input, const builder::Progress& progress);

}  // namespace spheretree::tool
