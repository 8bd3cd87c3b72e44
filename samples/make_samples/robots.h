// SPDX-License-Identifier: Apache-2.0
// Our own sample robots: a 7-joint arm with a gripper and a 6-joint industrial robot, as URDF with meshes in several
// formats, primitives, a scale, `package://` and a mimic joint. Their links have shapes like those of real robots:
// tubes with transverse joint housings, castings with motors, a bent wrist.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace spheretree::samples {

/// Files by their paths below the folder of the robot.
using RobotFiles = std::vector<std::pair<std::string, std::vector<std::byte>>>;

/// sample_arm7/: 11 links with shapes, 7 revolute joints and a gripper of two prismatic ones, about 1.2 m tall.
RobotFiles sampleArm7();

/// sample_arm6/: 7 links with shapes, 6 revolute joints, reach about 1.6 m.
RobotFiles sampleArm6();

}  // namespace spheretree::samples
