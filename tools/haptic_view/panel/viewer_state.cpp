// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/viewer_state.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace spheretree::view {
namespace {

/// Number of leaves between the eye and a point of the tool's shaft.
int hiding(const Stage& stage, const Eigen::Vector3d& eye, const Eigen::Vector3d& point) {
  int count = 0;
  const Eigen::Vector3d way = point - eye;
  const double length = way.norm();
  const Eigen::Vector3d along = way / length;
  for (const PlacedObject& object : stage.objects) {
    const Body& body = stage.bodies[object.body];
    if (body.levels.empty()) continue;
    for (const Ball& ball : body.levels.back()) {
      const Eigen::Vector3d c = object.pose.position + object.pose.orientation * Eigen::Vector3d(ball.x, ball.y, ball.z) - eye;
      const double at = c.dot(along);
      if (at > 0 && at < length - ball.radius && (c - at * along).norm() < ball.radius) ++count;
    }
  }
  return count;
}

}  // namespace

Layout layoutOf(const ViewerState& state, int width, int height, double scale) {
  Layout out;
  out.scene = {0, 0, width, height};
  const auto px = [scale](double v) { return static_cast<int>(std::lround(v * scale)); };
  if (state.panels && width > px(500)) {
    const int side = px(268);
    out.panel = {width - side, 0, side, height};
    out.scene.width -= side;
  }
  int bottom = height;
  if (state.panels && state.hasPlots() && height > px(360)) {
    const int high = px(122);
    bottom -= high;
    out.plots = {0, bottom, out.scene.width, high};
  }
  if (state.panels && state.playback && height > px(200)) {
    const int high = px(40);
    bottom -= high;
    out.scrubber = {0, bottom, out.scene.width, high};
  }
  out.scene.height = bottom;
  // Up to three side by side, more in rows.
  const auto count = static_cast<int>(std::max<std::size_t>(1, state.panes.size()));
  const int rows = count <= 3 ? 1 : 2, columns = (count + rows - 1) / rows;
  for (int k = 0; k < count; ++k) {
    const int left = out.scene.width * (k % columns) / columns, right = out.scene.width * (k % columns + 1) / columns;
    const int top = out.scene.height * (k / columns) / rows, end = out.scene.height * (k / columns + 1) / rows;
    out.panes.push_back({left, top, std::max(1, right - left), std::max(1, end - top)});
  }
  return out;
}

Camera firstCamera(const Stage& stage, std::optional<Eigen::Vector3d> tool, const Viewport& viewport) {
  Camera camera;
  camera.frame(stage.centre(), stage.radius(), viewport);
  if (!tool) return camera;
  const double near = std::max(0.6 * stage.toolReach(), 5.0);
  if (stage.radius() > 1.5 * near) {
    camera.frame(*tool, near, viewport);
  } else {
    const Eigen::Vector3d middle = 0.5 * (stage.centre() + *tool);
    camera.frame(middle, std::max(stage.radius() + (stage.centre() - middle).norm(), 0.5 * near), viewport);
  }
  constexpr std::array<std::array<double, 2>, 7> kDirections{
      {{-1.1, 0.45}, {-2.0, 0.45}, {1.1, 0.45}, {2.0, 0.45}, {1.57, 0.15}, {-1.57, 0.15}, {-1.1, 1.0}}};
  int smallest = 1 << 30;
  Camera best = camera;
  for (const auto& [azimuth, elevation] : kDirections) {
    camera.azimuth = azimuth;
    camera.elevation = elevation;
    const int count = hiding(stage, camera.eye(), *tool);
    if (count < smallest) best = camera;
    smallest = std::min(smallest, count);
  }
  return best;
}

Camera wishedCamera(const Stage& stage, std::optional<Eigen::Vector3d> tool, const CameraWish& wish, const Viewport& viewport) {
  Camera camera = firstCamera(stage, tool, viewport);
  if (wish.from) {
    camera.azimuth = std::atan2(wish.from->y(), wish.from->x());
    camera.elevation = std::atan2(wish.from->z(), std::hypot(wish.from->x(), wish.from->y()));
  }
  if (wish.within > 0) camera.frame(tool.value_or(stage.centre()), wish.within, viewport);
  return camera;
}

void frameWhole(ViewerState& state, const Viewport& viewport) {
  const Eigen::Vector3d centre = state.panes[0].stage->centre();
  double radius = 0;
  if (state.fills_panes) return state.camera.frame(centre, state.panes[0].stage->radius(), viewport);
  for (const Pane& pane : state.panes)
    radius = std::max(radius, pane.stage->radius() + (pane.stage->centre() - pane.shift - centre).norm());
  state.camera.frame(centre, radius, viewport);
}

Camera cameraOf(const ViewerState& state, std::size_t pane) {
  Camera camera = state.camera;
  const Stage &first = *state.panes[0].stage, &stage = *state.panes[pane].stage;
  if (state.fills_panes) {
    const double ratio = stage.radius() / first.radius();
    camera.target = stage.centre() + ratio * (camera.target - first.centre());
    camera.distance *= ratio;
  } else {
    camera.target += state.panes[pane].shift;
  }
  return camera;
}

Eigen::Vector3d shiftBetween(const Stage& first, const Stage& other) {
  const Eigen::Vector3d shift = other.centre() - first.centre();
  return 2 * shift.norm() > first.radius() + other.radius() ? shift : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

}  // namespace spheretree::view
