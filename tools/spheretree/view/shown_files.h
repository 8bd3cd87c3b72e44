// SPDX-License-Identifier: GPL-3.0-or-later
// Files as stages for viewing: meshes, trees, soft trees, robots, scenes and comparisons. Units: mm.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "model/stage.h"
#include "panel/viewer_state.h"
#include "robot/robot_input.h"
#include "spheretree/builder/progress.h"

namespace spheretree::tool {

inline constexpr std::size_t kMaxPanes = 6;

struct ShownFile {
  std::string title;
  view::Stage stage;
  std::vector<view::FigureLine> figures;
  std::vector<std::string> notes;
  /// (bodies)(levels)(corners of the balls) how far the corner is outside the mesh [mm]; may be empty
  std::vector<std::vector<std::vector<double>>> outside;
  bool opens_on_spheres = false, opens_on_overhang = false;  // what shows best what the file is about; otherwise its meshes
};

struct ShownRequest {
  std::vector<std::filesystem::path> files;
  std::string mesh;         // of a comparison; "": its first
  std::string unit;         // of meshes without a unit, and of all meshes of a robot; "": mm, and m for a robot
  robot::RobotInput robot;  // its `packages` and `is_visual`
};

/// The stages to show, one for each pane. If FILES has a mesh or a robot followed by trees or spheres, the mesh is
/// shown with each of them, and the overhang of the balls is measured against it. A mesh in several colours is shown as
/// one object for each colour of each part. A scene is shown with its poses, a robot with its joints at 0. A comparison
/// (its folder or compare.json) is shown as the trees of one mesh: the best tree of each builder, without the search
/// where there is one, the smallest overhang first. Colours of the overhang have one scale for all panes.
/// @throws UsageError for more than kMaxPanes; the exceptions of the readers
std::vector<std::unique_ptr<ShownFile>> shownFiles(const ShownRequest& request, builder::Progress& progress);

}  // namespace spheretree::tool
