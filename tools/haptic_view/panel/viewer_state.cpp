// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/viewer_state.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "draw/pick.h"

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
    const Eigen::Vector3d middle = object.pose.position + object.pose.orientation * body.box.center() - eye;
    if ((middle - middle.dot(along) * along).norm() > 0.6 * body.box.sizes().norm()) continue;  // balls reach a little beyond the box
    for (const Ball& ball : body.levels.back()) {
      const Eigen::Vector3d c = object.pose.position + object.pose.orientation * Eigen::Vector3d(ball.x, ball.y, ball.z) - eye;
      const double at = c.dot(along);
      if (at > 0 && at < length - ball.radius && (c - at * along).norm() < ball.radius) ++count;
    }
  }
  return count;
}

void extend(Eigen::AlignedBox3d& all, const Eigen::AlignedBox3d& box, const Configuration& pose) {
  if (box.isEmpty()) return;
  for (int corner = 0; corner < 8; ++corner)
    all.extend(pose.position + pose.orientation * box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)));
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

Camera firstCamera(const Stage& stage, const std::optional<Configuration>& tool, const Viewport& viewport) {
  Camera camera;
  camera.y_up = stage.y_up;
  camera.frame(stage.centre(), stage.radius(), viewport);
  if (!tool) return camera;
  Eigen::AlignedBox3d tool_box, all;
  if (stage.tool)
    extend(tool_box, stage.bodies[*stage.tool].box, {tool->position - tool->orientation * stage.reference_point, tool->orientation});
  tool_box.extend(tool->position);
  const double reach = tool_box.sizes().norm() / 2;
  std::vector<Eigen::Vector3d> seen{tool->position};  // what should not be hidden
  for (const PlacedObject& object : stage.objects)
    if (const Body& body = stage.bodies[object.body]; body.is_tooth && !body.box.isEmpty()) {
      extend(all, body.box, object.pose);
      seen.push_back(object.pose.position + object.pose.orientation * body.box.center());
    }
  constexpr double kMuchLarger = 4;  // than the tool: an object of which only a part is seen
  if (all.isEmpty())
    for (const PlacedObject& object : stage.objects)
      if (stage.radius() <= kMuchLarger * reach && !stage.bodies[object.body].box.isEmpty())
        extend(all, stage.bodies[object.body].box, object.pose);
  all.extend(tool_box);
  camera.frame(all.center(), std::max(all.sizes().norm() / 2, 5.0), viewport);
  constexpr std::array<std::array<double, 2>, 10> kDirections{{{-1.1, 0.45},
                                                               {-2.0, 0.45},
                                                               {1.1, 0.45},
                                                               {2.0, 0.45},
                                                               {1.57, 0.15},
                                                               {-1.57, 0.15},
                                                               {-1.1, 1.0},
                                                               {1.1, 1.0},
                                                               {2.0, 1.0},
                                                               {1.57, 0.6}}};
  int smallest = 1 << 30;
  Camera best = camera;
  for (const auto& [azimuth, elevation] : kDirections) {
    camera.azimuth = azimuth;
    camera.elevation = elevation;
    int count = 0;
    for (const Eigen::Vector3d& point : seen) count += hiding(stage, camera.eye(), point);
    if (count < smallest) best = camera;
    smallest = std::min(smallest, count);
  }
  return best;
}

ShownState shownState(const Pane& pane) {
  ShownState out;
  out.has_tool = pane.has_state;
  out.haptic = pane.state.step.haptic;
  out.graphic = pane.state.step.graphic;
  out.wrench = pane.state.step.wrench;
  if (pane.has_state) out.tool_mark = pane.stage->toolMark();
  out.contacts = {pane.state.contacts.data(), pane.state.contact_count};
  out.carriers = pane.carriers;
  out.tissue = pane.tissue;
  out.removal = pane.removal;
  return out;
}

std::vector<FigureLine> objectFigures(const Pane& pane, std::size_t object) {
  const Body& body = pane.stage->bodies[pane.stage->objects[object].body];
  std::vector<FigureLine> out;
  const auto add = [&](const char* name, const char* format, double value) {
    char text[48];
    std::snprintf(text, sizeof text, format, value);
    out.push_back({name, text});
  };
  if (!body.levels.empty()) add("leaves", "%.0f", static_cast<double>(body.levels.back().size()));
  if (body.overhang >= 0) add("overhang, at most", "%.3g mm", body.overhang);
  if (!pane.has_state) return out;
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  bool is_touched = false;
  for (std::uint32_t k = 0; k < pane.state.contact_count; ++k)
    if (const ShownContact& contact = pane.state.contacts[k]; contact.object == object) {
      force += (contact.force * contact.normal + contact.friction).cast<double>();
      is_touched = true;
    }
  if (is_touched) {
    add("force on the tool", "%.2f N", force.norm());
    if (pane.state.step.touched == object) add("penetration", "%.1f um", 1000 * pane.state.step.penetration);
  } else if (const auto gap = gapToObject(*pane.stage, shownState(pane), object)) {
    add("distance to the tool", "%.2f mm", *gap);
  }
  return out;
}

Camera wishedCamera(const Stage& stage, const std::optional<Configuration>& tool, const CameraWish& wish, const Viewport& viewport) {
  Camera camera = firstCamera(stage, tool, viewport);
  if (wish.from) camera.lookFrom(*wish.from);
  if (wish.within > 0) camera.frame(tool ? tool->position : stage.centre(), wish.within, viewport);
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
