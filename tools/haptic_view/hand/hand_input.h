// SPDX-License-Identifier: GPL-3.0-or-later
// Converts drags, keys, sticks and knobs to the target pose of the hand. Directions are relative to the view: right is
// right on the screen.
// Units: mm, rad, s; pixels of the viewport.
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "draw/camera.h"
#include "spheretree/core/rigid.h"

namespace spheretree::view {

enum class HandSource : std::uint8_t { Mouse, Keyboard, Gamepad, SpaceMouse, File };

/// Six values from -1 to 1: right, up, towards the eye, and rotations about these axes.
using Deflection = std::array<double, 6>;

/// Values below `zone` become 0, and the remaining range is stretched to reach 1.
double withDeadZone(double value, double zone);

/// Sticks and triggers as GLFW reports them: left x, left y (down is positive), right x, right y, left trigger, right
/// trigger (-1 at rest). The left stick moves in the view plane, the triggers towards and away from the eye. The right
/// stick rotates; with `turn_about_view` (a bumper) its sideways motion rotates about the view direction. Dead zone 15
/// %.
Deflection gamepadDeflection(const std::array<float, 6>& axes, bool turn_about_view);

/// x, y, z and rotations about them as a 3D mouse reports them (right, up, towards the user; 350 is full deflection).
/// Dead zone 3 %.
Deflection spaceMouseDeflection(const std::array<int, 6>& motion);

/// The target pose of the hand.
class HandInput {
 public:
  static constexpr double kKeySpeed = 20, kKeyTurn = 0.8;  // [mm/s, rad/s]
  static constexpr double kStickSpeed = 40,
                          kStickTurn =
                              1.5;  // at full deflection; the speed follows the cube of the deflection, so that it is slow near the middle
  static constexpr double kWheelStep = 0.5;      // motion for one notch [mm]
  static constexpr double kTurnOfPixel = 0.006;  // [rad]

  void resetTo(const Configuration& pose) { pose_ = pose; }
  const Configuration& pose() const { return pose_; }

  /// Moves by pixels in the plane of the view through the hand, so that the point under the pointer stays under it.
  void drag(double right, double down, const Camera& camera, const Viewport& viewport);
  /// Moves away from the eye.
  void push(double mm, const Camera& camera);
  /// Rotates as if the pointer rolled the tool.
  void turn(double right, double down, const Camera& camera);
  /// Moves for `seconds` at the full speed of keys. Diagonals are not faster.
  void hold(const Deflection& keys, double seconds, const Camera& camera);
  /// Moves for `seconds` according to the deflection of a stick.
  void steer(const Deflection& sticks, double seconds, const Camera& camera);

 private:
  void move(const Deflection& way, const Camera& camera);
  Configuration pose_;
};

}  // namespace spheretree::view
