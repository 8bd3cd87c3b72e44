// SPDX-License-Identifier: GPL-3.0-or-later
// The effect of pointer and keys on camera, hand, replay and look. Reads ImGui::GetIO(), whose keys are numbered as by
// GLFW.
#pragma once

#include <string>
#include <vector>

#include "panel/viewer_state.h"

namespace spheretree::view {

/// Keys, numbered as by GLFW.
enum Key : int {
  kKeySpace = 32,
  kKeyMinus = 45,
  kKey1 = 49,
  kKeyEqual = 61,
  kKeyA = 65,
  kKeyBracketLeft = 91,
  kKeyBracketRight = 93,
  kKeyEscape = 256,
  kKeyBackspace = 259,
  kKeyRight = 262,
  kKeyLeft = 263,
  kKeyDown = 264,
  kKeyUp = 265,
  kKeyPageUp = 266,
  kKeyPageDown = 267,
  kKeyHome = 268,
  kKeyEnd = 269,
  kKeyF1 = 290,
};
constexpr Key keyOf(char letter) { return static_cast<Key>(kKeyA + (letter - 'A')); }

/// Call once a frame, before the panels are drawn.
void applyControls(ViewerState& state, const Layout& layout, double seconds);

/// A line of the help: key or gesture, and its effect in the current mode of the state.
struct HelpLine {
  std::string key, does;
};
std::vector<HelpLine> helpLines(const ViewerState& state);

}  // namespace spheretree::view
