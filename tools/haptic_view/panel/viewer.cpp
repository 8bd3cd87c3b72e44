// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/viewer.h"

#include <imgui.h>

#include "panel/controls.h"
#include "panel/panels.h"

namespace spheretree::view {
namespace {

Viewport times(const Viewport& v, int samples) { return {v.x * samples, v.y * samples, v.width * samples, v.height * samples}; }

}  // namespace

Viewer::Viewer(const Gl& gl, Interface& interface, ViewerState& state) : gl_(gl), interface_(interface), state_(state), screen_(gl) {
  for (const Pane& pane : state.panes) drawers_.push_back(std::make_unique<SceneDrawer>(gl, *pane.stage));
}

void Viewer::frame(int width, int height, int samples, double seconds, GLuint target) {
  interface_.setTheme(state_.look.theme);
  message_age_ = state_.message == message_ ? message_age_ + seconds : 0;
  message_ = state_.message;
  constexpr double kMessageTime = 10;  // [s]
  if (message_age_ > kMessageTime) state_.message.clear();
  const Layout layout = layoutOf(state_, width, height, interface_.scale());
  applyControls(state_, layout, seconds);
  const Pane& first = state_.panes[0];
  if (first.has_state) {
    const Eigen::Vector3d& at = first.state.step.graphic.position;
    if (state_.follow && has_followed_) state_.camera.target += at - followed_;
    followed_ = at;
    has_followed_ = true;
  }
  state_.look.marked = state_.panes.size() == 1 ? state_.selected : std::nullopt;
  drawPanels(state_, layout, interface_.scale());

  screen_.begin(width, height, samples);
  const Theme theme = themeOf(state_.look.theme);
  gl_.Disable(GL_SCISSOR_TEST);
  gl_.ClearColor(static_cast<float>(theme.bottom.r) / 255, static_cast<float>(theme.bottom.g) / 255,
                 static_cast<float>(theme.bottom.b) / 255, 1);
  gl_.Clear(GL_COLOR_BUFFER_BIT);
  for (std::size_t k = 0; k < drawers_.size(); ++k) {
    drawers_[k]->draw(cameraOf(state_, k), state_.look, shownState(state_.panes[k]), times(layout.panes[k], samples), screen_.frameHeight(),
                      samples * interface_.scale());
  }
  screen_.resolve(target);
  interface_.end();
}

}  // namespace spheretree::view
