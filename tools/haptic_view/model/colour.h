// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>

namespace spheretree::view {

/// Red, green, blue, opacity.
struct Colour {
  std::uint8_t r = 255, g = 255, b = 255, a = 255;
  friend bool operator==(const Colour&, const Colour&) = default;
};

/// The colour at `share` of the way from `a` to `b`, 0 .. 1, with the opacity of `a`.
inline Colour mixed(Colour a, Colour b, double share) {
  const auto between = [share](std::uint8_t x, std::uint8_t y) {
    return static_cast<std::uint8_t>(std::lround((1 - share) * x + share * y));
  };
  return {between(a.r, b.r), between(a.g, b.g), between(a.b, b.b), a.a};
}

}  // namespace spheretree::view
