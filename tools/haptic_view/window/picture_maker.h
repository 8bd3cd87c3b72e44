// SPDX-License-Identifier: GPL-3.0-or-later
// A picture of what a window would show, drawn without one: for documents and tests.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "draw/offscreen.h"
#include "panel/viewer.h"

namespace spheretree::view {

/// "1280x800", each from 64 to 8192; nothing for anything else.
std::optional<std::array<int, 2>> sizeOf(const std::string& text);

class PictureMaker {
 public:
  /// `state` must outlive it; `scale`: of text and marks. One at a time. @throws ViewError
  PictureMaker(int width, int height, double scale, ViewerState& state);
  /// `state` as it is now, each pixel the mean of sixteen.
  Picture draw();
  Layout layout() const { return layoutOf(state_, width_, height_, interface_.scale()); }

 private:
  int width_, height_;
  ViewerState& state_;
  OffscreenContext context_;
  Interface interface_;
  Viewer viewer_;
  Canvas canvas_;
};

}  // namespace spheretree::view
