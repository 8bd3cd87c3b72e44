// SPDX-License-Identifier: GPL-3.0-or-later
// In place of scenario_command.cpp where the program was built without the builders.
#include "program_end.h"
#include "scenario_command.h"

namespace spheretree::player {

constexpr const char* kNotBuilt = "this haptic-player was built without the builders, which scenarios and comparisons need. Name a scene";

int listScenarios() { throw tool::UsageError(kNotBuilt); }

int runScenarioCommand(const ScenarioOptions&, double, runtime::ContactSurface, bool, const ViewOptions&, tool::WorkProgress&) {
  throw tool::UsageError(kNotBuilt);
}

int runCuttingCommand(const CuttingOptions&, bool, builder::Progress&) { throw tool::UsageError(kNotBuilt); }
int runToolsCommand(const ToolsOptions&, bool, tool::WorkProgress&) { throw tool::UsageError(kNotBuilt); }

}  // namespace spheretree::player
