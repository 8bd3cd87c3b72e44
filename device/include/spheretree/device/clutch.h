// SPDX-License-Identifier: Apache-2.0
// A clutch: while its button is held, the hand moves and the tool does not, as with a mouse that is lifted.
#pragma once

#include <cstdint>

#include "spheretree/core/rigid.h"

namespace spheretree::device {

class Clutch {
 public:
  explicit Clutch(std::uint32_t buttons = 0) noexcept : buttons_(buttons) {}

  /// The position that the renderer sees while the handle is at `position` and `held` buttons are pressed. The
  /// orientation needs no clutch: it has no limited workspace. A position that is not finite changes nothing.
  Eigen::Vector3d follow(const Eigen::Vector3d& position, std::uint32_t held) noexcept {
    if (!position.allFinite()) return position;
    const bool is_held = (held & buttons_) != 0;
    if (is_held && !was_held_) frozen_ = position + offset_;
    if (is_held || was_held_) offset_ = frozen_ - position;
    was_held_ = is_held;
    return is_held ? frozen_ : Eigen::Vector3d(position + offset_);
  }

 private:
  std::uint32_t buttons_;
  bool was_held_ = false;
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero(), frozen_ = Eigen::Vector3d::Zero();
};

}  // namespace spheretree::device
