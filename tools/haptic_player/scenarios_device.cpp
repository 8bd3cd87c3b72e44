// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of moving objects, hands and safety.
#include "scenario.h"

namespace spheretree::player {

std::vector<Scenario> deviceScenarios() { return {}; }

}  // namespace spheretree::player
