// SPDX-License-Identifier: GPL-3.0-or-later
// haptic-player --scenario and --list.
#pragma once

#include <filesystem>
#include <string>

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

/// Both return an exit code. `rate`: servo steps in a second [Hz].
/// @throws tool::UsageError, also where the program was built without the builders, which make the scenarios' trees.
int listScenarios();
int runScenarioCommand(const ScenarioOptions& options, double rate, runtime::ContactSurface contact, bool json, const ViewOptions& view,
                       tool::WorkProgress& progress);

}  // namespace spheretree::player
