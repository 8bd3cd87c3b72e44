// SPDX-License-Identifier: GPL-3.0-or-later
#include "options/robot_options.h"

#include "robot/model/robot_shapes.h"

namespace spheretree::tool {

void addRobotInput(CLI::App& app, robot::RobotInput& input) {
  app.add_option("--package", input.packages,
                 "Folder to search for package:// and model://, before the folders above the URDF, ROS_PACKAGE_PATH and "
                 "AMENT_PREFIX_PATH; or NAME=FOLDER, the folder of the package NAME; may be given again; default: none")
      ->type_name("[NAME=]DIR")
      ->allow_extra_args(false);
  app.add_flag("--visual", input.is_visual, "Take the shapes of <visual> of a robot in place of those of <collision>; default: off");
}

std::string unitFault(const std::string& text) {
  return robot::linkUnit(text) ? "" : text + " is neither mm, cm, m or in, nor PATTERN=UNIT with one of these";
}

}  // namespace spheretree::tool
