// SPDX-License-Identifier: GPL-3.0-or-later
// A window of the desktop with OpenGL, pointer, keys and gamepad. One at a time, used by the main thread.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "draw/gl.h"
#include "panel/interface.h"

struct GLFWwindow;

namespace spheretree::view {

/// Whether the environment names a display. A window may fail to open all the same.
bool hasDisplay();

struct GamepadState {
  std::array<float, 6> axes;  // as gamepadDeflection() takes them
  bool bumper;                // either of the two is held
};

class Window {
 public:
  /// `scale`: of text and marks; 0: that of the display. @throws ViewError: what is missing and what to do.
  Window(const std::string& title, int width, int height, double scale);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  const Gl& gl() const { return gl_; }
  Interface& interface() { return *interface_; }
  bool isOpen() const;
  void close();
  int width() const { return width_; }  // [pixels]
  int height() const { return height_; }
  /// Draws of each pixel, in each direction: 1 where the processor draws, else 2.
  int samples() const { return is_software_ ? 1 : 2; }

  /// Waits until a frame is due (60 a second; 30 where the processor draws, so that it has time for other things),
  /// takes what pointer and keys did, and begins the interface's frame. Returns the time since the last one [s].
  double begin();
  /// Shows the frame.
  void present();
  /// The first gamepad, if there is one.
  std::optional<GamepadState> gamepad() const;

 private:
  using Clock = std::chrono::steady_clock;
  GLFWwindow* window_ = nullptr;
  Gl gl_;
  std::unique_ptr<Interface> interface_;
  void takeTaps();

  std::vector<int> pressed_, released_later_;  // keys
  int pressed_with_ = 0;                       // modifiers, as GLFW gives them
  bool is_software_ = false;
  int width_ = 0, height_ = 0;
  Clock::time_point last_, due_;
};

}  // namespace spheretree::view
