// SPDX-License-Identifier: GPL-3.0-or-later
#include "window/picture_maker.h"

#include <algorithm>
#include <charconv>

namespace spheretree::view {

std::optional<std::array<int, 2>> sizeOf(const std::string& text) {
  int width = 0, height = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, width);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != 'x') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, height);
  if (second.ec != std::errc() || second.ptr != end) return std::nullopt;
  if (width < 64 || height < 64 || width > 8192 || height > 8192) return std::nullopt;
  return std::array<int, 2>{width, height};
}

PictureMaker::PictureMaker(int width, int height, double scale, ViewerState& state)
    : width_(width),
      height_(height),
      state_(state),
      interface_(scale),
      viewer_(context_.gl(), interface_, state),
      canvas_(context_.gl(), width, height) {}

Picture PictureMaker::draw() {
  constexpr int kSamples = 4;  // samples of a pixel, in each direction
  GLint largest = 0;           // side of an image that the driver draws into [pixels]
  context_.gl().GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
  const int fitting = std::clamp(largest / std::max(width_, height_), 1, kSamples);
  // Panels compute their size in the first frame and have it in the second.
  for (const int samples : {1, fitting}) {
    interface_.begin(width_, height_, 1.0 / 60);
    viewer_.frame(width_, height_, samples, 0, canvas_.id());
  }
  return readPixels(context_.gl(), canvas_);
}

}  // namespace spheretree::view
