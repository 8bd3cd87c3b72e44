// SPDX-License-Identifier: GPL-3.0-or-later
// The options by which verbs read a robot.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "robot/robot_input.h"

namespace spheretree::tool {

/// --package and --visual.
void addRobotInput(CLI::App& app, robot::RobotInput& input);

/// For a list of units: "" or what is wrong with the text.
std::string unitFault(const std::string& text);

}  // namespace spheretree::tool
