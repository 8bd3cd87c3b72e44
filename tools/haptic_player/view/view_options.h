// SPDX-License-Identifier: GPL-3.0-or-later
// The options of haptic-player for display. What they select: settings_of_options.h, run_view.h
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <vector>

namespace spheretree::player {

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

}  // namespace spheretree::player
