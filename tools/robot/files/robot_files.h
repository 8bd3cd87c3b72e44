// SPDX-License-Identifier: GPL-3.0-or-later
// The spheres of a robot in the formats of planners and simulators. Each function returns the content of one file; the
// formats and their readers: docs/robots.md. Lengths in metres, in the frames of the links.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "robot/cover/ignored_pairs.h"
#include "robot/cover/robot_cover.h"
#include "run_files.h"

namespace spheretree::robot {

/// The data to write.
struct CoveredRobot {
  const Robot& robot;
  const RobotCover& cover;
  const std::vector<IgnoredPair>& pairs;
  std::filesystem::path srdf;   // its groups and pairs are kept; may be empty
  std::filesystem::path merge;  // .xrdf or .yml whose other keys are kept; may be empty
};

/// cuRobo, robot_cfg.kinematics.
std::string curoboYaml(const CoveredRobot& covered);
/// XRDF 1.0.
std::string xrdf(const CoveredRobot& covered);
/// The URDF with spheres instead of its collision elements; paths relative to the URDF become relative to `folder`.
std::string sphereUrdf(const CoveredRobot& covered, const std::filesystem::path& folder);
/// Spheres, and pairs to ignore; a note if `covered.srdf` names links that the robot does not have.
std::string srdf(const CoveredRobot& covered, std::vector<std::string>& notes);
/// For fkcc_gen, the generator of VAMP; the names are those of the files beside it.
std::string vampJson(const CoveredRobot& covered, const std::string& urdf, const std::string& srdf);
/// For one link: a list by depth.
std::string foamJson(const LinkCover& link);
/// For ballpark and PyRoKi.
std::string ballparkJson(const CoveredRobot& covered);
/// For one link.
std::string morphitJson(const Robot& robot, const LinkCover& link);
/// The manifest, by which `view` and `report` find the robot again: what it was read from, with paths relative to
/// `folder`, and the figures of its links. readManifest() of robot_input.h reads it.
std::string manifestJson(const CoveredRobot& covered, const std::filesystem::path& folder);
/// MuJoCo; a note for each inertia and name that it does not accept as the URDF has it.
std::string mjcf(const CoveredRobot& covered, std::vector<std::string>& notes);

/// The name of the manifest, and its schema.
inline constexpr const char *kManifestName = "robot.json", *kManifestSchema = "spheretree.robot/1";

/// The names of all files relative to the folder of the results, known before the first build.
std::vector<std::filesystem::path> robotFileNames(const Robot& robot);

struct RobotFiles {
  std::vector<std::string> contents;  // in the order of robotFileNames()
  std::vector<std::string> notes;     // what they change in sentences that name the place
};

/// Before the first build, a cover without links shows what will be refused or noted.
/// @throws formats::FileError; formats::FormatError if a file cannot be merged
RobotFiles robotFiles(const CoveredRobot& covered, const std::filesystem::path& folder);

/// Creates their folders, including `folder`. @throws formats::FileError
void makeRobotFolders(const std::filesystem::path& folder, const tool::RunFiles& files);

/// Writes the files and returns their names. @throws formats::FileError; formats::FormatError if a file cannot be
/// merged; then nothing is written.
std::vector<std::filesystem::path> writeRobotFiles(const CoveredRobot& covered, const std::filesystem::path& folder);

}  // namespace spheretree::robot
