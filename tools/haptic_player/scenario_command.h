// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-player --scenario, --list, --compare-cutting and --compare-tools.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "spheretree/runtime/scene.h"
#include "view/view_options.h"
#include "work_progress.h"

namespace spheretree::player {

struct ScenarioOptions {
  std::string scenario, modes = "paper,constrained", quality = "standard";
  std::filesystem::path out, cache, chart;
  double share = 1;
  int turned = 1, threads = 0;
};

/// A scene in which a burr cuts, and how the hand moves; both empty: a block (comparison/cutting.h).
struct CuttingOptions {
  std::filesystem::path scene, trajectory, cache, chart;
  double voxel = 0.1;  // edge [mm]
};

/// Which tools and bodies of comparison/tool_models.h, or "all"; how deep the hand is [mm].
struct ToolsOptions {
  std::vector<std::string> names;
  double depth = 0.5;
  std::filesystem::path cache, chart;
};

/// All return an exit code. `rate`: servo steps in a second [Hz].
/// @throws tool::UsageError, also where the program was built without the builders, which make the scenarios' trees.
int listScenarios();
int runScenarioCommand(const ScenarioOptions& options, double rate, runtime::ContactSurface contact, bool json, const ViewOptions& view,
                       tool::WorkProgress& progress);
int runCuttingCommand(const CuttingOptions& options, bool json, builder::Progress& progress);
int runToolsCommand(const ToolsOptions& options, bool json, tool::WorkProgress& progress);

}  // namespace spheretree::player
