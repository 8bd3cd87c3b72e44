// SPDX-License-Identifier: GPL-3.0-or-later
// From drags, keys, sticks and knobs to where the hand means to be. Everything is meant as it looks: right is right on
// the screen.
// Units: mm, rad, s; pixels of the viewport.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "draw/camera.h"
#include "spheretree/core/rigid.h"

namespace spheretree::view {

enum class HandSource : std::uint8_t { Mouse, Keyboard, Gamepad, SpaceMouse, File };

/// Six directions from -1 to 1: right, up, towards the eye, and turns about these axes.
using Deflection = std::array<double, 6>;

/// What is below `zone` counts as nothing, and the rest is stretched to reach 1.
double withDeadZone(double value, double zone);

/// Sticks and triggers as GLFW gives them: left x, left y (down is positive), right x, right y, left trigger, right
/// trigger (-1 at rest). The left stick moves in the view plane, the triggers to and from the eye, the right stick
/// turns; with `turn_about_view` (a bumper) its sideways turns about the view direction. Dead zone 15 %.
Deflection gamepadDeflection(const std::array<float, 6>& axes, bool turn_about_view);

/// x, y, z and rotations about them as a 3D mouse sends them (right, up, towards the user; 350 is the full way). Dead
/// zone 3 %.
Deflection spaceMouseDeflection(const std::array<int, 6>& motion);

/// Where the hand means to be.
class HandInput {
 public:
  static constexpr double kKeySpeed = 20, kKeyTurn = 0.8;      // [mm/s, rad/s]
  static constexpr double kStickSpeed = 40, kStickTurn = 1.5;  // at full deflection, after a cube: slow in the middle
  static constexpr double kWheelStep = 0.5;                    // of a notch [mm]
  static constexpr double kTurnOfPixel = 0.006;                // [rad]

  void resetTo(const Configuration& pose) { pose_ = pose; }
  const Configuration& pose() const { return pose_; }

  /// By so many pixels in the plane of the view through the hand: what is under the pointer stays under it.
  void drag(double right, double down, const Camera& camera, const Viewport& viewport);
  /// Away from the eye.
  void push(double mm, const Camera& camera);
  /// As if the pointer rolled the tool.
  void turn(double right, double down, const Camera& camera);
  /// For `seconds` at the full speed of keys. Diagonals are no faster.
  void hold(const Deflection& keys, double seconds, const Camera& camera);
  /// For `seconds` by the deflection of a stick.
  void steer(const Deflection& sticks, double seconds, const Camera& camera);

 private:
  void move(const Deflection& way, const Camera& camera);
  Configuration pose_;
};

}  // namespace spheretree::view
