// SPDX-License-Identifier: GPL-3.0-or-later
// Text, panels and what pointer and keys do, by Dear ImGui: one for each window or picture.
#pragma once

#include "draw/look.h"

struct ImDrawList;
struct ImVec2;

namespace spheretree::view {

/// Packed as Dear ImGui wants it.
unsigned packed(Colour colour);
unsigned packed(Colour colour, double opacity);

class Interface {
 public:
  /// `scale`: of text and panels, 1 for about 96 pixels an inch. A context of OpenGL must be current.
  explicit Interface(double scale);
  ~Interface();
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;

  double scale() const { return scale_; }
  void setTheme(ThemeKind kind);
  /// Without a window: a frame of this size, `seconds` after the last one. Pointer and keys are what ImGui::GetIO()
  /// holds.
  void begin(int width, int height, double seconds);
  /// In a window, whose back end says size and time.
  void begin();
  /// Draws into the bound frame.
  void end();

 private:
  double scale_;
  ThemeKind theme_ = ThemeKind::Dark;
};

}  // namespace spheretree::view
