// SPDX-License-Identifier: GPL-3.0-or-later
// The options of haptic-player for display, and the actions that they select.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "play.h"
#include "spheretree/builder/progress.h"

namespace spheretree::player {

struct Scenario;
struct ScenarioContext;

struct ViewOptions {
  bool view = false;
  std::string hand_from;  // mouse, keyboard, gamepad, spacemouse or file; empty: file if there is a trajectory, else mouse
  std::filesystem::path replay, compare, picture;
  std::string at;    // TICK or FROM:TO:EVERY
  std::string size;  // WxH
  std::string theme = "dark", show = "meshes", panels = "on";
  std::vector<double> from;  // direction from the target to the eye; empty: automatic
  double within = 0;         // radius of the visible region around the tool [mm]; 0: automatic
  bool follow = false;
  double scale = 0;  // of text and marks; 0: that of the display
  bool isAsked() const { return view || !replay.empty() || !picture.empty(); }
};

void addViewOptions(CLI::App& cli, ViewOptions& options);

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
