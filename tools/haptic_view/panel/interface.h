// SPDX-License-Identifier: GPL-3.0-or-later
// Text, panels, and the handling of pointer and keys, by Dear ImGui: one for each window or picture.
#pragma once

#include "draw/look.h"

struct ImDrawList;
struct ImVec2;

namespace spheretree::view {

/// A colour in the format of Dear ImGui.
unsigned packed(Colour colour);
unsigned packed(Colour colour, double opacity);

class Interface {
 public:
  /// `scale` of text and panels: 1 for about 96 pixels an inch. An OpenGL context must be current.
  explicit Interface(double scale);
  ~Interface();
  Interface(const Interface&) = delete;
  Interface& operator=(const Interface&) = delete;

  double scale() const { return scale_; }
  void setTheme(ThemeKind kind);
  /// Begins a frame without a window, of this size, `seconds` after the last one. Pointer and keys are those in
  /// ImGui::GetIO().
  void begin(int width, int height, double seconds);
  /// Begins a frame in a window, whose back end supplies size and time.
  void begin();
  /// Draws into the bound framebuffer.
  void end();

 private:
  double scale_;
  ThemeKind theme_ = ThemeKind::Dark;
};

}  // namespace spheretree::view
