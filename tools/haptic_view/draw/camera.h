// SPDX-License-Identifier: GPL-3.0-or-later
// The camera: it looks at a target from a direction and a distance. The z axis of the world points up, or its y axis.
// Units: mm, rad; pixels from the upper left corner.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

namespace spheretree::view {

/// A part of the window, in pixels from its upper left corner.
struct Viewport {
  int x = 0, y = 0, width = 1, height = 1;
  double aspect() const { return static_cast<double>(width) / height; }
};

struct Ray {
  Eigen::Vector3d origin, direction;  // of unit length
};

class Camera {
 public:
  Eigen::Vector3d target = Eigen::Vector3d::Zero();
  double azimuth = -1.1, elevation = 0.45;  // direction from the target to the eye; azimuth from x towards y, elevation in [-pi/2, pi/2]
  double distance = 100;                    // > 0
  double opening = 0.6;                     // vertical angle of view
  bool y_up = false;                        // azimuth and elevation are then those of a scene that was turned upright, y to z

  Eigen::Vector3d towardsEye() const;
  Eigen::Vector3d right() const;
  Eigen::Vector3d up() const;
  Eigen::Vector3d eye() const { return target + distance * towardsEye(); }

  Eigen::Matrix4d view() const;
  /// Depth from 0 (near) to 1; both distances along the view direction, 0 < near < far.
  Eigen::Matrix4d projection(double aspect, double near, double far) const;
  /// Nearest and farthest distance that include a ball, with space for what is drawn around it.
  std::array<double, 2> depthRange(const Eigen::Vector3d& centre, double radius) const;

  /// Rotates the camera by angles, as if the hand rotated the scene.
  void orbit(double to_the_left, double upwards);
  /// Moves the target so that points in the plane of the target follow the pointer.
  void pan(double right_pixels, double down_pixels, const Viewport& viewport);
  /// A factor above 1 moves the camera nearer.
  void zoom(double factor);
  /// Shows the whole ball, from the current direction.
  void frame(const Eigen::Vector3d& centre, double radius, const Viewport& viewport);
  /// 1 to 6: from the front (-y; with `y_up` z), the back, the left (-x), the right, above, below.
  void lookFrom(int side);
  /// Looks from this direction, not zero.
  void lookFrom(const Eigen::Vector3d& direction);

  /// Size of a pixel at the depth of `point` [mm].
  double pixelAt(const Eigen::Vector3d& point, const Viewport& viewport) const;
  /// The position of a point in the window; empty for a point behind the eye.
  std::optional<Eigen::Vector2d> pixelOf(const Eigen::Vector3d& point, const Viewport& viewport) const;
  /// The ray from the eye through a pixel.
  Ray rayThrough(const Eigen::Vector2d& pixel, const Viewport& viewport) const;
};

}  // namespace spheretree::view
