// SPDX-License-Identifier: GPL-3.0-or-later
#include "panel/controls.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "draw/pick.h"

namespace spheretree::view {
namespace {

constexpr double kOrbitOfPixel = 0.008;  // [rad]
constexpr double kZoomOfNotch = 1.15;

bool pressed(int key, bool repeats = false) { return ImGui::IsKeyPressed(key, repeats); }

/// 1 if `plus` is held, -1 if `minus` is held.
double between(int minus, int plus) { return (ImGui::IsKeyDown(plus) ? 1.0 : 0.0) - (ImGui::IsKeyDown(minus) ? 1.0 : 0.0); }

bool movesHand(const ViewerState& state) { return state.hand && state.hand_source == HandSource::Mouse; }

/// The pane under the pointer; the first one if there is none.
Viewport paneUnder(const Layout& layout, ImVec2 pointer) {
  for (const Viewport& pane : layout.panes)
    if (pointer.x >= static_cast<float>(pane.x) && pointer.x < static_cast<float>(pane.x + pane.width) &&
        pointer.y >= static_cast<float>(pane.y) && pointer.y < static_cast<float>(pane.y + pane.height))
      return pane;
  return layout.panes[0];
}

void toggle(std::vector<bool>& flags, std::size_t object, std::size_t count) {
  flags.resize(count, false);
  flags[object] = !flags[object];
}

/// Names the object under the pointer; a click, which moves nothing, chooses it.
void pointAtObject(ViewerState& state, const Layout& layout) {
  const ImGuiIO& io = ImGui::GetIO();
  const bool is_dragged = io.MouseDown[0] || io.MouseDown[1] || io.MouseDown[2];
  state.hovered.reset();
  if (state.panes.size() != 1 || is_dragged || !ImGui::IsMousePosValid()) return;
  const Viewport& pane = layout.panes[0];
  const Eigen::Vector2d at(static_cast<double>(io.MousePos.x), static_cast<double>(io.MousePos.y));
  if (at.x() < pane.x || at.y() < pane.y || at.x() >= pane.x + pane.width || at.y() >= pane.y + pane.height) return;
  state.hovered = pickObject(*state.panes[0].stage, state.look, shownState(state.panes[0]), state.camera.rayThrough(at, pane));
  constexpr float kStill = 16;  // squared [pixels^2]: a hand that clicks moves a little
  if (io.MouseReleased[0] && io.MouseDragMaxDistanceSqr[0] < kStill) state.selected = state.hovered;
}

void applyPointer(ViewerState& state, const Layout& layout) {
  const ImGuiIO& io = ImGui::GetIO();
  state.hovered.reset();
  if (io.WantCaptureMouse) return;
  pointAtObject(state, layout);
  const Viewport pane = paneUnder(layout, io.MousePos);
  // In the frame of the press, the way to its place belongs to no drag: a pen or a touch screen jumps there.
  const bool is_press = io.MouseClicked[0] || io.MouseClicked[1] || io.MouseClicked[2];
  const double right = is_press ? 0 : static_cast<double>(io.MouseDelta.x), down = is_press ? 0 : static_cast<double>(io.MouseDelta.y);
  const bool drives = movesHand(state) && !io.KeyCtrl;
  const bool left_button = io.MouseDown[0], right_button = io.MouseDown[1], middle_button = io.MouseDown[2];
  if (drives && left_button) state.hand->drag(right, down, state.camera, pane);
  if (drives && right_button) state.hand->turn(right, down, state.camera);
  const bool pans = (middle_button && io.KeyShift) || (right_button && !drives) || (left_button && !drives && io.KeyShift);
  const bool orbits = !pans && (middle_button || (left_button && !drives));
  if (orbits) state.camera.orbit(-kOrbitOfPixel * right, kOrbitOfPixel * down);
  if (pans) state.camera.pan(right, down, pane);
  const double notches = static_cast<double>(io.MouseWheel);
  if (notches == 0) return;
  if (drives)
    state.hand->push(HandInput::kWheelStep * notches, state.camera);
  else
    state.camera.zoom(std::pow(kZoomOfNotch, notches));
}

void frameContact(ViewerState& state, const Layout& layout) {
  const Pane& pane = state.panes[0];
  if (!pane.has_state) return frameWhole(state, layout.panes[0]);
  Eigen::Vector3d at = pane.state.step.graphic.position;
  if (pane.state.contact_count > 0) {
    at.setZero();
    for (std::uint32_t k = 0; k < pane.state.contact_count; ++k)
      at += pane.state.contacts[k].point.cast<double>() / static_cast<double>(pane.state.contact_count);
  }
  state.camera.frame(at, std::max(3.0, 0.08 * pane.stage->toolReach()), layout.panes[0]);
}

void applyObjectKeys(ViewerState& state) {
  Look& look = state.look;
  if (pressed(keyOf('U'))) look.hidden.clear(), look.glass.clear();
  const auto object = state.hovered ? state.hovered : state.selected;
  if (!object) return;
  const std::size_t count = state.panes[0].stage->objects.size();
  if (pressed(keyOf('H'))) toggle(look.hidden, *object, count);
  if (pressed(keyOf('G'))) toggle(look.glass, *object, count);
}

void applyLookKeys(ViewerState& state, const Layout& layout) {
  Look& look = state.look;
  applyObjectKeys(state);
  if (pressed(keyOf('Y'))) state.camera.y_up = !state.camera.y_up;
  for (int side = 1; side <= 6; ++side)
    if (pressed(kKey1 + side - 1)) state.camera.lookFrom(side);
  if (pressed(keyOf('F'))) frameContact(state, layout);
  if (!state.playback && pressed(kKeyHome)) frameWhole(state, layout.panes[0]);
  if (state.panes.size() > 1 && pressed(keyOf('Z'))) {
    state.fills_panes = !state.fills_panes;
    frameWhole(state, layout.panes[0]);
  }
  if (pressed(keyOf('O'))) state.follow = !state.follow;
  if (pressed(keyOf('T'))) look.theme = look.theme == ThemeKind::Dark ? ThemeKind::Light : ThemeKind::Dark;
  if (pressed(keyOf('M'))) look.objects = look.tool = static_cast<Geometry>((static_cast<int>(look.objects) + 1) % 4);
  const int last = std::max(0, state.panes[0].stage->levelCount() - 1);
  if (pressed(kKeyBracketLeft, true)) look.level = std::max(0, std::min(look.level, last) - 1);
  if (pressed(kKeyBracketRight, true)) look.level = std::min(last, look.level + 1);
  if (pressed(keyOf('X'))) look.cut = !look.cut;
  if (pressed(keyOf('P'))) state.panels = !state.panels;
  bool asks = pressed(kKeyF1);
  for (const ImWchar c : ImGui::GetIO().InputQueueCharacters) asks = asks || c == '?';
  if (asks) state.help = !state.help;
  if (pressed(kKeyEscape)) state.help = false;
  if (pressed(keyOf('Q')) && ImGui::GetIO().KeyCtrl) state.wants_quit = true;
}

void applyReplayKeys(Playback& playback) {
  const double many = ImGui::GetIO().KeyShift ? 100 : 1;
  if (pressed(kKeySpace)) playback.toggle();
  if (pressed(kKeyRight, true)) playback.nudge(many);
  if (pressed(kKeyLeft, true)) playback.nudge(-many);
  if (pressed(kKeyHome)) playback.seek(0);
  if (pressed(kKeyEnd)) playback.seek(1e18);
  if (pressed(kKeyUp)) playback.setSpeed(playback.speed() * 2);
  if (pressed(kKeyDown)) playback.setSpeed(playback.speed() / 2);
}

void applyCourseKeys(RunCourse& course) {
  if (pressed(kKeySpace)) course.is_paused = !course.is_paused;
  if (pressed(keyOf('N'), true)) {
    course.is_paused = true;
    course.wanted_steps += ImGui::GetIO().KeyShift ? 100 : 1;
  }
  if (pressed(kKeyMinus)) course.slowness = std::min(2 * course.slowness, RunCourse::kSlowest);
  if (pressed(kKeyEqual)) course.slowness = std::max(course.slowness / 2, 1);
  if (pressed(kKeyBackspace)) course.wants_restart = true;
}

void applyHandKeys(ViewerState& state, double seconds) {
  const bool takes_keys = state.hand_source == HandSource::Mouse || state.hand_source == HandSource::Keyboard;
  if (!takes_keys || ImGui::GetIO().KeyCtrl) return;
  const Deflection keys{between(kKeyLeft, kKeyRight),    between(kKeyDown, kKeyUp),       between(kKeyPageUp, kKeyPageDown),
                        between(keyOf('W'), keyOf('S')), between(keyOf('A'), keyOf('D')), between(keyOf('E'), keyOf('Q'))};
  if (std::any_of(keys.begin(), keys.end(), [](double k) { return k != 0; })) state.hand->hold(keys, seconds, state.camera);
}

}  // namespace

void applyControls(ViewerState& state, const Layout& layout, double seconds) {
  applyPointer(state, layout);
  if (ImGui::GetIO().WantTextInput) return;
  applyLookKeys(state, layout);
  if (state.can_capture && pressed(keyOf('C'))) state.wants_picture = true;
  if (state.can_capture && pressed(keyOf('V'))) state.wants_film = true;
  if (state.playback) {
    applyReplayKeys(*state.playback);
    state.playback->advance(seconds);
    return;
  }
  if (state.hand) applyHandKeys(state, seconds);
  if (state.course.is_live) applyCourseKeys(state.course);
  if (state.course.is_live && pressed(keyOf('Z'))) state.frozen = !state.frozen;
  if (state.can_record && pressed(keyOf('R'))) state.wants_record = true;
  if (state.can_spin && pressed(keyOf('B'))) state.wants_spindle = true;
}

std::vector<HelpLine> helpLines(const ViewerState& state) {
  std::vector<HelpLine> out;
  const auto add = [&](const char* key, const char* does) { out.push_back({key, does}); };
  if (movesHand(state)) {
    add("drag", "move the hand in the plane of the view");
    add("wheel", "push it away from you, or pull it");
    add("right drag", "turn it");
    add("middle or Ctrl drag", "orbit; with Shift or the right button: shift the view");
    add("Ctrl wheel", "zoom");
  } else {
    add("drag", "orbit");
    add("right drag", "shift the view");
    add("wheel", "zoom");
  }
  if (state.hand && state.hand_source != HandSource::File) {
    add("arrows, Page Up, Page Down", "move the hand at 20 mm/s");
    add("A D W S Q E", "turn it");
  }
  if (state.can_spin) add("B", "start and stop the burr");
  if (state.hand_source == HandSource::Gamepad) add("left stick, triggers, right stick", "move the hand, push it, turn it");
  if (state.playback) {
    add("Space", "play, pause");
    add("Left, Right", "one step back or forward; with Shift: 100 steps");
    add("Up, Down", "faster, slower");
    add("Home, End", "to the beginning, to the end");
  } else if (state.course.is_live) {
    add("Space", "pause, go on");
    add("N", "one step; with Shift: 100 steps");
    add("- =", "half, double the pace, 1/32 to real time");
    add("Backspace", "begin again: tool and bodies at the start");
    add("Z", "freeze the plots");
  }
  if (state.can_record) add("R", "start and stop a recording");
  if (state.can_capture) {
    add("C", "screenshot");
    add("V", "start and stop a film");
  }
  if (state.panes.size() == 1) {
    add("click", "figures of an object; the pointer names it");
    add("H, G, U", "hide it, make it glass, show all");
  }
  add("1 .. 6", "from the front, the back, left, right, above, below");
  add("F", state.panes[0].has_state ? "to the contact" : "the whole");
  if (!state.playback) add("Home", "the whole scene");
  if (state.panes.size() > 1) add("Z", "each fills its pane, or all at one scale");
  add("O", "follow the tool");
  add("M", "meshes, spheres, bounding spheres, contact surface");
  add("[ ]", "a level up, down");
  add("X", "a hole in what hides the tool");
  add("Y", "up: the z axis, the y axis");
  add("T", "dark, light");
  add("P", "panels");
  add("Ctrl Q", "close");
  return out;
}

}  // namespace spheretree::view
