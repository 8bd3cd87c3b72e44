// SPDX-License-Identifier: GPL-3.0-or-later
#include "window/window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <imgui.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

namespace spheretree::view {
namespace {

/// The last error that GLFW reported.
std::string complaint() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

}  // namespace

bool hasDisplay() {
  const auto isSet = [](const char* name) {
    const char* value = std::getenv(name);
    return value && *value;
  };
  return isSet("DISPLAY") || isSet("WAYLAND_DISPLAY");
}

Window::Window(const std::string& title, int width, int height, double scale) {
  const std::string advice =
      ". Log in to a desktop, or set DISPLAY (over ssh: ssh -X). Without a display --picture OUT.png draws into a file";
  if (!glfwInit()) throw ViewError("no window can be opened: " + complaint() + advice);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);  // scenes are drawn into a framebuffer of their own
  glfwWindowHintString(GLFW_X11_CLASS_NAME, "spheretree");
  window_ = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr);
  if (!window_) {
    const std::string why = complaint();
    glfwTerminate();
    throw ViewError("no window can be opened: " + why +
                    ". OpenGL 3.3 is needed: install libgl1-mesa-dri, which draws without a graphics card");
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  gl_ = loadGl(glfwGetProcAddress);
  is_software_ = isSoftware(rendererName(gl_));
  float across = 1, down = 1;
  glfwGetWindowContentScale(window_, &across, &down);
  interface_ = std::make_unique<Interface>(scale > 0 ? scale : std::clamp(static_cast<double>(across), 1.0, 4.0));
  glfwSetWindowUserPointer(window_, this);
  glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int modifiers) {
    if (action != GLFW_PRESS || key < 0) return;
    auto& self = *static_cast<Window*>(glfwGetWindowUserPointer(window));
    self.pressed_.push_back(key);
    self.pressed_with_ |= modifiers;
  });
  ImGui_ImplGlfw_InitForOpenGL(window_, true);  // it also calls the callback above
  last_ = due_ = Clock::now();
}

Window::~Window() {
  ImGui_ImplGlfw_Shutdown();
  interface_.reset();
  glfwDestroyWindow(window_);
  glfwTerminate();
}

bool Window::isOpen() const { return !glfwWindowShouldClose(window_); }
void Window::close() { glfwSetWindowShouldClose(window_, GLFW_TRUE); }

/// A key that was pressed and released between two frames counts as held in this one: otherwise a quick tap would be
/// lost on a slow machine.
void Window::takeTaps() {
  ImGuiIO& io = ImGui::GetIO();
  for (const int key : released_later_) io.KeysDown[key] = false;
  released_later_.clear();
  for (const int key : pressed_) {
    if (io.KeysDown[key]) continue;
    io.KeysDown[key] = true;
    released_later_.push_back(key);
  }
  pressed_.clear();
  // Control and Shift as at the time of the key press, even if they were released since.
  io.KeyCtrl = io.KeysDown[GLFW_KEY_LEFT_CONTROL] || io.KeysDown[GLFW_KEY_RIGHT_CONTROL] || (pressed_with_ & GLFW_MOD_CONTROL);
  io.KeyShift = io.KeysDown[GLFW_KEY_LEFT_SHIFT] || io.KeysDown[GLFW_KEY_RIGHT_SHIFT] || (pressed_with_ & GLFW_MOD_SHIFT);
  pressed_with_ = 0;
}

double Window::begin() {
  const Clock::time_point now = Clock::now();
  if (now < due_) std::this_thread::sleep_until(due_);
  due_ = std::max(due_, now) + std::chrono::microseconds(is_software_ ? 33'000 : 16'000);
  glfwPollEvents();
  glfwGetFramebufferSize(window_, &width_, &height_);
  width_ = std::max(width_, 64);  // a hidden window has no size
  height_ = std::max(height_, 64);
  ImGui_ImplGlfw_NewFrame();
  takeTaps();
  // Everything here is in pixels; the back end uses units of the desktop, which may be larger.
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = {io.MousePos.x * io.DisplayFramebufferScale.x, io.MousePos.y * io.DisplayFramebufferScale.y};
  io.DisplaySize = {static_cast<float>(width_), static_cast<float>(height_)};
  io.DisplayFramebufferScale = {1, 1};
  interface_->begin();
  const Clock::time_point begun = Clock::now();
  return std::chrono::duration<double>(begun - std::exchange(last_, begun)).count();
}

void Window::present() { glfwSwapBuffers(window_); }

std::optional<GamepadState> Window::gamepad() const {
  for (int pad = GLFW_JOYSTICK_1; pad <= GLFW_JOYSTICK_LAST; ++pad) {
    GLFWgamepadstate state;
    if (!glfwGetGamepadState(pad, &state)) continue;
    const float* a = state.axes;
    return GamepadState{{a[GLFW_GAMEPAD_AXIS_LEFT_X], a[GLFW_GAMEPAD_AXIS_LEFT_Y], a[GLFW_GAMEPAD_AXIS_RIGHT_X],
                         a[GLFW_GAMEPAD_AXIS_RIGHT_Y], a[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER], a[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER]},
                        state.buttons[GLFW_GAMEPAD_BUTTON_LEFT_BUMPER] || state.buttons[GLFW_GAMEPAD_BUTTON_RIGHT_BUMPER],
                        state.buttons[GLFW_GAMEPAD_BUTTON_A] != 0};
  }
  return std::nullopt;
}

std::string Window::gamepadIdentity() const {
  GLFWgamepadstate state;
  for (int pad = GLFW_JOYSTICK_1; pad <= GLFW_JOYSTICK_LAST; ++pad)
    if (glfwGetGamepadState(pad, &state))
      if (const char* identity = glfwGetJoystickGUID(pad)) return identity;
  return "";
}

}  // namespace spheretree::view
