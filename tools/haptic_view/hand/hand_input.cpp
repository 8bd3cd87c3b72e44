// SPDX-License-Identifier: GPL-3.0-or-later
#include "hand/hand_input.h"

#include <algorithm>
#include <cmath>

namespace spheretree::view {

double withDeadZone(double value, double zone) {
  const double beyond = std::abs(value) - zone;
  return beyond > 0 ? std::copysign(std::min(1.0, beyond / (1 - zone)), value) : 0;
}

Deflection gamepadDeflection(const std::array<float, 6>& axes, bool turn_about_view) {
  const auto stick = [&](std::size_t k) { return withDeadZone(static_cast<double>(axes[k]), 0.15); };
  const auto trigger = [&](std::size_t k) { return withDeadZone(0.5 + 0.5 * static_cast<double>(axes[k]), 0.15); };
  const double sideways = stick(2);
  return {stick(0), -stick(1), trigger(4) - trigger(5), stick(3), turn_about_view ? 0 : sideways, turn_about_view ? -sideways : 0};
}

Deflection spaceMouseDeflection(const std::array<int, 6>& motion) {
  Deflection out{};
  for (std::size_t k = 0; k < 6; ++k) out[k] = withDeadZone(std::clamp(motion[k] / 350.0, -1.0, 1.0), 0.03);
  return out;
}

void HandInput::drag(double right, double down, const Camera& camera, const Viewport& viewport) {
  const double mm = camera.pixelAt(pose_.position, viewport);
  move({right * mm, -down * mm, 0, 0, 0, 0}, camera);
}

void HandInput::push(double mm, const Camera& camera) { move({0, 0, -mm, 0, 0, 0}, camera); }

void HandInput::turn(double right, double down, const Camera& camera) {
  move({0, 0, 0, kTurnOfPixel * down, kTurnOfPixel * right, 0}, camera);
}

void HandInput::hold(const Deflection& keys, double seconds, const Camera& camera) {
  Deflection way{};
  for (const std::size_t first : {std::size_t{0}, std::size_t{3}}) {
    const double length = std::sqrt(keys[first] * keys[first] + keys[first + 1] * keys[first + 1] + keys[first + 2] * keys[first + 2]);
    const double scale = seconds * (first == 0 ? kKeySpeed : kKeyTurn) / std::max(1.0, length);
    for (std::size_t k = first; k < first + 3; ++k) way[k] = scale * keys[k];
  }
  move(way, camera);
}

void HandInput::steer(const Deflection& sticks, double seconds, const Camera& camera) {
  Deflection way{};
  for (std::size_t k = 0; k < 6; ++k) way[k] = seconds * (k < 3 ? kStickSpeed : kStickTurn) * sticks[k] * sticks[k] * sticks[k];
  move(way, camera);
}

void HandInput::move(const Deflection& way, const Camera& camera) {
  const Eigen::Vector3d right = camera.right(), up = camera.up(), towards = camera.towardsEye();
  pose_ = moved(pose_, {way[0] * right + way[1] * up + way[2] * towards, way[3] * right + way[4] * up + way[5] * towards});
}

}  // namespace spheretree::view
