// SPDX-License-Identifier: GPL-3.0-or-later
// A picture of a window's content, drawn without a window, for documents and tests.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "draw/offscreen.h"
#include "panel/viewer.h"

namespace spheretree::view {

/// Parses "1280x800", each from 64 to 8192; otherwise empty.
std::optional<std::array<int, 2>> sizeOf(const std::string& text);

class PictureMaker {
 public:
  /// `state` must outlive the object; `scale` of text and marks. Only one at a time. @throws ViewError
  PictureMaker(int width, int height, double scale, ViewerState& state);
  /// Draws the current `state`; each pixel is the mean of sixteen, or of fewer if the driver draws no image that large.
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
