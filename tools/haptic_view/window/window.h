// SPDX-License-Identifier: GPL-3.0-or-later
// A desktop window with OpenGL, pointer, keys and gamepad. Only one at a time, used by the main thread.
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

/// Whether the environment names a display. Opening a window may still fail.
bool hasDisplay();

struct GamepadState {
  std::array<float, 6> axes;  // in the order of gamepadDeflection()
  bool bumper;                // one of the two is held
  bool button;                // the lowest of the four on the right is held
};

class Window {
 public:
  /// `scale` of text and marks; 0: that of the display. @throws ViewError; the message says what is missing and what to
  /// do.
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
  /// Samples of each pixel in each direction: 1 if the processor renders, otherwise 2.
  int samples() const { return is_software_ ? 1 : 2; }

  /// Waits until the next frame (60 a second; 30 if the processor renders, to leave it time for other work), takes the
  /// input of pointer and keys, and begins the interface's frame. Returns the time since the last frame [s].
  double begin();
  /// Shows the frame.
  void present();
  /// The state of the first gamepad, if there is one.
  std::optional<GamepadState> gamepad() const;
  /// Its identity, as idsOfGamepad() reads it; empty if there is no gamepad.
  std::string gamepadIdentity() const;

 private:
  using Clock = std::chrono::steady_clock;
  GLFWwindow* window_ = nullptr;
  Gl gl_;
  std::unique_ptr<Interface> interface_;
  void takeTaps();

  std::vector<int> pressed_, released_later_;  // keys
  int pressed_with_ = 0;                       // modifiers, in GLFW's encoding
  bool is_software_ = false;
  int width_ = 0, height_ = 0;
  Clock::time_point last_, due_;
};

}  // namespace spheretree::view
