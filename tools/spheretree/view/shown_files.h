// SPDX-License-Identifier: GPL-3.0-or-later
// Files as stages to be seen: meshes, trees, scenes and comparisons. Units: mm.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "model/stage.h"
#include "panel/viewer_state.h"
#include "spheretree/builder/progress.h"

namespace spheretree::tool {

inline constexpr std::size_t kMostPanes = 6;

struct ShownFile {
  std::string title;
  view::Stage stage;
  std::vector<view::FigureLine> figures;
  std::vector<std::string> notes;
};

/// What is to be shown, one for each pane. Of FILES, a mesh followed by trees stands beside each of them, and says how
/// far their balls reach out; a scene is shown as it is placed; a comparison (its folder or compare.json) as the trees
/// of one mesh, `mesh` or the first, tightest first. `unit_mm`: one unit of a mesh without one.
/// @throws UsageError for more than kMostPanes; what the readers throw
std::vector<std::unique_ptr<ShownFile>> shownFiles(const std::vector<std::filesystem::path>& files, const std::string& mesh, double unit_mm,
                                                   builder::Progress& progress);

}  // namespace spheretree::tool
