// SPDX-License-Identifier: GPL-3.0-or-later
// What the options of haptic-player for display select: a window or pictures of a run, of recordings or of a scenario.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "run/play.h"
#include "spheretree/builder/progress.h"
#include "view/view_options.h"

namespace spheretree::player {

struct Scenario;
struct ScenarioContext;

/// Whether a window can be opened: a display exists, and the program was built with a view.
bool canShowWindow();

/// Why no window can be opened, and what to do: one line.
const char* whyNoWindow();

/// Runs or replays with a window or for pictures. `summary` is that of play(), or null after a replay.
/// @throws tool::UsageError, view::ViewError, and the exceptions of play()
PlayEnd runView(const ViewOptions& options, PlaySettings& play, builder::Progress& progress, nlohmann::ordered_json& summary);

/// Shows a scenario in both modes, side by side. Returns an exit code. @throws tool::UsageError, view::ViewError
int viewScenario(const ViewOptions& options, const Scenario& scenario, ScenarioContext& context, builder::Progress& progress);

}  // namespace spheretree::player
