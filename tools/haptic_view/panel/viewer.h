// SPDX-License-Identifier: GPL-3.0-or-later
// One frame of a window or one picture: input, panels, scenes. Not knowing where the frame goes, it is the same for
// both.
#pragma once

#include <memory>
#include <vector>

#include "draw/scene_drawer.h"
#include "panel/interface.h"
#include "panel/viewer_state.h"

namespace spheretree::view {

class Viewer {
 public:
  /// The stages of `state.panes` must outlive it. @throws ViewError
  Viewer(const Gl& gl, Interface& interface, ViewerState& state);

  /// Between Interface::begin() and its end, which is called here: answers pointer and keys, draws into `target` (0:
  /// the window).
  /// `samples`: of each pixel, in each direction; `seconds` since the last frame.
  void frame(int width, int height, int samples, double seconds, GLuint target);

 private:
  const Gl& gl_;
  Interface& interface_;
  ViewerState& state_;
  std::vector<std::unique_ptr<SceneDrawer>> drawers_;  // (panes)
  Screen screen_;
  Eigen::Vector3d followed_ = Eigen::Vector3d::Zero();
  bool has_followed_ = false;
};

}  // namespace spheretree::view
