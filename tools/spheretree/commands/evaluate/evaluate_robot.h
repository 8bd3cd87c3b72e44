// SPDX-License-Identifier: GPL-3.0-or-later
// evaluate ROBOT.urdf SPHERES: measures the spheres of every link against its collision shapes, whichever program made
// them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "robot/robot_input.h"
#include "spheretree/builder/evaluate_tree.h"

namespace spheretree::tool {

struct EvaluateRobotOptions {
  robot::RobotInput input;
  std::filesystem::path spheres;
  std::string link;                      // "": all
  std::optional<double> sphere_unit_mm;  // empty: as the file states it, or metres
  std::string repair = "auto";
  bool json = false;
  builder::EvaluateSettings settings;
};

/// Prints a row for each link with collision shapes; a link without spheres is uncovered. Returns an exit code.
int evaluateRobot(const EvaluateRobotOptions& options, bool quiet, builder::Progress& progress);

}  // namespace spheretree::tool
