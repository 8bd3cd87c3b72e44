// SPDX-License-Identifier: GPL-3.0-or-later
// An OpenGL context without a window or a display, by EGL, for pictures and tests. Only one at a time; it must be used
// by the thread that created it.
#pragma once

#include <cstdint>
#include <vector>

#include "draw/gl.h"

namespace spheretree::view {

/// Pixels in rows from the upper left corner, three bytes each: red, green, blue.
struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
};

class OffscreenContext {
 public:
  /// @throws ViewError; the message says what to install.
  OffscreenContext();
  ~OffscreenContext();
  OffscreenContext(const OffscreenContext&) = delete;
  OffscreenContext& operator=(const OffscreenContext&) = delete;
  const Gl& gl() const { return gl_; }

 private:
  void* display_ = nullptr;
  void* surface_ = nullptr;
  void* context_ = nullptr;
  Gl gl_;
};

/// The content of `canvas`.
Picture readPixels(const Gl& gl, const Canvas& canvas);
/// The lower left part of the bound framebuffer.
Picture readPixels(const Gl& gl, int width, int height);
/// Depth of each pixel, from 0 (near) to 1, in the order of a Picture.
std::vector<float> readDepth(const Gl& gl, const Canvas& canvas);

/// Encodes a PNG file. Same picture, same bytes.
std::vector<std::byte> encodePng(const Picture& picture);

}  // namespace spheretree::view
