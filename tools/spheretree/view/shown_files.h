// SPDX-License-Identifier: GPL-3.0-or-later
// Files as stages for viewing: meshes, trees, scenes and comparisons. Units: mm.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "model/stage.h"
#include "panel/viewer_state.h"
#include "spheretree/builder/progress.h"

namespace spheretree::tool {

inline constexpr std::size_t kMaxPanes = 6;

struct ShownFile {
  std::string title;
  view::Stage stage;
  std::vector<view::FigureLine> figures;
  std::vector<std::string> notes;
  std::vector<std::vector<double>> outside;  // (levels)(corners of the balls) how far the corner is outside the mesh [mm]
};

/// The stages to show, one for each pane. If FILES has a mesh followed by trees, the mesh is shown beside each tree,
/// and the overhang of the balls is measured against it. A scene is shown with its poses. A comparison (its folder or
/// compare.json) is shown as the trees of one mesh (`mesh`, or the first one): the best tree of each builder, without
/// the search where there is one, the smallest overhang first. Colours of the overhang have one scale for all panes.
/// `unit_mm`: one unit of a mesh without a unit.
/// @throws UsageError for more than kMaxPanes; the exceptions of the readers
std::vector<std::unique_ptr<ShownFile>> shownFiles(const std::vector<std::filesystem::path>& files, const std::string& mesh, double unit_mm,
                                                   builder::Progress& progress);

}  // namespace spheretree::tool
