// SPDX-License-Identifier: GPL-3.0-or-later
#include "draw/camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace spheretree::view {

using Eigen::Vector3d;

namespace {

/// From a scene whose z axis points up to the world.
Vector3d inWorld(const Vector3d& v, bool y_up) { return y_up ? Vector3d(v.x(), v.z(), -v.y()) : v; }

}  // namespace

Vector3d Camera::towardsEye() const {
  return inWorld({std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth), std::sin(elevation)}, y_up);
}

Vector3d Camera::right() const { return inWorld({-std::sin(azimuth), std::cos(azimuth), 0}, y_up); }

Vector3d Camera::up() const { return towardsEye().cross(right()); }

Eigen::Matrix4d Camera::view() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.block<1, 3>(0, 0) = right().transpose();
  m.block<1, 3>(1, 0) = up().transpose();
  m.block<1, 3>(2, 0) = towardsEye().transpose();
  m.block<3, 1>(0, 3) = -m.block<3, 3>(0, 0) * eye();
  return m;
}

Eigen::Matrix4d Camera::projection(double aspect, double near, double far) const {
  const double f = 1 / std::tan(opening / 2);
  Eigen::Matrix4d m = Eigen::Matrix4d::Zero();
  m(0, 0) = f / aspect;
  m(1, 1) = f;
  m(2, 2) = (far + near) / (near - far);  // clip space ranges from -1 to 1, the depth buffer from 0 to 1
  m(2, 3) = 2 * far * near / (near - far);
  m(3, 2) = -1;
  return m;
}

std::array<double, 2> Camera::depthRange(const Vector3d& centre, double radius) const {
  const double middle = (eye() - centre).dot(towardsEye());
  const double far = std::max(middle + 1.5 * radius, 2 * distance);
  return {std::max(middle - 1.5 * radius, std::min(0.05 * distance, 0.01 * far)), far};
}

void Camera::orbit(double to_the_left, double upwards) {
  azimuth = std::remainder(azimuth + to_the_left, 2 * std::numbers::pi);
  elevation = std::clamp(elevation + upwards, -std::numbers::pi / 2, std::numbers::pi / 2);
}

void Camera::pan(double right_pixels, double down_pixels, const Viewport& viewport) {
  const double mm = pixelAt(target, viewport);
  target -= mm * (right_pixels * right() - down_pixels * up());
}

void Camera::zoom(double factor) { distance = std::clamp(distance / factor, 1e-2, 1e6); }

void Camera::frame(const Vector3d& centre, double radius, const Viewport& viewport) {
  target = centre;
  const double half = std::atan(std::tan(opening / 2) * std::min(1.0, viewport.aspect()));
  distance = std::max(radius, 1e-3) / std::sin(half);
}

void Camera::lookFrom(int side) {
  constexpr double kQuarter = std::numbers::pi / 2;
  constexpr std::array<std::array<double, 2>, 6> kSides{
      {{-kQuarter, 0}, {kQuarter, 0}, {2 * kQuarter, 0}, {0, 0}, {-kQuarter, kQuarter}, {-kQuarter, -kQuarter}}};
  if (side < 1 || side > 6) return;
  azimuth = kSides[static_cast<std::size_t>(side - 1)][0];
  elevation = kSides[static_cast<std::size_t>(side - 1)][1];
}

void Camera::lookFrom(const Vector3d& direction) {
  const Vector3d d = y_up ? Vector3d(direction.x(), -direction.z(), direction.y()) : direction;
  azimuth = std::atan2(d.y(), d.x());
  elevation = std::atan2(d.z(), std::hypot(d.x(), d.y()));
}

double Camera::pixelAt(const Vector3d& point, const Viewport& viewport) const {
  const double depth = (eye() - point).dot(towardsEye());
  return 2 * std::tan(opening / 2) * std::max(depth, 1e-6) / viewport.height;
}

std::optional<Eigen::Vector2d> Camera::pixelOf(const Vector3d& point, const Viewport& viewport) const {
  const Vector3d from_eye = point - eye();
  const double depth = -from_eye.dot(towardsEye());
  if (!(depth > 1e-9)) return std::nullopt;
  const double scale = viewport.height / (2 * std::tan(opening / 2) * depth);
  return Eigen::Vector2d(viewport.x + viewport.width / 2.0 + scale * from_eye.dot(right()),
                         viewport.y + viewport.height / 2.0 - scale * from_eye.dot(up()));
}

Ray Camera::rayThrough(const Eigen::Vector2d& pixel, const Viewport& viewport) const {
  const double scale = 2 * std::tan(opening / 2) / viewport.height;
  const double x = scale * (pixel.x() - viewport.x - viewport.width / 2.0), y = scale * (viewport.y + viewport.height / 2.0 - pixel.y());
  return {eye(), (x * right() + y * up() - towardsEye()).normalized()};
}

}  // namespace spheretree::view
