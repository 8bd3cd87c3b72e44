// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of a window or one picture: input, panels, scenes. It does not depend on the target of the frame, so both
// look the same.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "draw/scene_drawer.h"
#include "panel/interface.h"
#include "panel/viewer_state.h"

namespace spheretree::view {

class Viewer {
 public:
  /// The stages of `state.panes` must outlive the object. @throws ViewError
  Viewer(const Gl& gl, Interface& interface, ViewerState& state);

  /// Call it after Interface::begin(); it calls Interface::end(). Handles pointer and keys, and draws into `target` (0:
  /// the window). `samples`: of each pixel, in each direction; `seconds` since the last frame.
  void frame(int width, int height, int samples, double seconds, GLuint target);

 private:
  const Gl& gl_;
  Interface& interface_;
  ViewerState& state_;
  std::vector<std::unique_ptr<SceneDrawer>> drawers_;  // (panes)
  Screen screen_;
  Eigen::Vector3d followed_ = Eigen::Vector3d::Zero();
  bool has_followed_ = false;
  std::string message_;
  double message_age_ = 0;  // for which it has been shown [s]
};

}  // namespace spheretree::view
