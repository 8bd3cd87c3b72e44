// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>

namespace spheretree::view {

/// No display, no OpenGL 3.3, no input device, or a driver that refuses. The message says what is missing and what to
/// do.
struct ViewError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace spheretree::view
