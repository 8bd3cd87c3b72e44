// SPDX-License-Identifier: GPL-3.0-or-later
// The renderers of the stability scenarios: the two modes of our runtime, and three published methods for comparison.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/runtime/step.h"

namespace spheretree::player {

enum class Mode : std::uint8_t {
  Published,    // leaf spheres, the published method that this project builds on
  Constrained,  // our method
  Points,       // points against a distance field, penalty: points_renderer.cpp
  Volume,       // inner spheres, penetration volume: volume_renderer.cpp
  Continuous,   // points against a distance field, time of impact, constraints: continuous_renderer.cpp
};
inline constexpr std::array kModes{Mode::Published, Mode::Constrained, Mode::Points, Mode::Volume, Mode::Continuous};

/// The name for --modes: "paper", "constrained", "points", "volume", "continuous".
std::string_view name(Mode mode);

/// The modes of a comma-separated list, each once, in the order of kModes. @throws std::invalid_argument; the message
/// lists the valid names.
std::vector<Mode> modesOf(const std::string& list);

/// Whether the runtime renders this mode, and with which of its modes.
inline bool isOurs(Mode mode) { return mode == Mode::Published || mode == Mode::Constrained; }
inline runtime::Mode runtimeMode(Mode mode) { return mode == Mode::Published ? runtime::Mode::Published : runtime::Mode::Constrained; }

}  // namespace spheretree::player
