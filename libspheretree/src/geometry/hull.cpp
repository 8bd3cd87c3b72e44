// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/hull.h"

#include <algorithm>
#include <cmath>

namespace spheretree::builder {

using Eigen::Vector3d;

Eigen::AlignedBox3d boxOf(const Hull& hull) {
  Eigen::AlignedBox3d box;
  for (std::size_t k = 0; k < hull.count; ++k) {
    const Vector3d half = Vector3d::Constant(hull.ball[k].radius);
    box.extend(Vector3d(hull.ball[k].centre - half)).extend(Vector3d(hull.ball[k].centre + half));
  }
  return box;
}

HullDistance::Side HullDistance::sideOf(const Ball& a, const Ball& b) {
  const Vector3d way = b.centre - a.centre;
  const double length = way.norm(), rise = b.radius - a.radius;
  if (!(std::abs(rise) < length)) return {rise > 0 ? b.centre : a.centre, Vector3d::UnitX(), 0, std::max(a.radius, b.radius), 0, 0};
  const double slope = rise / length;
  return {a.centre, way / length, length, a.radius, slope, slope / std::sqrt(1 - slope * slope)};
}

double HullDistance::Side::distance(const Vector3d& p) const {
  const Vector3d v = p - from;
  const double x = v.dot(along), height = (v - x * along).norm();
  const double t = std::clamp(x + height * shift, 0.0, length);
  return std::sqrt((x - t) * (x - t) + height * height) - radius - slope * t;
}

HullDistance::HullDistance(const Hull& hull) : sides_(hull.count == 3 ? 3 : 1) {
  for (std::size_t k = 0; k < sides_; ++k) side_[k] = sideOf(hull.ball[k], hull.ball[(k + 1) % hull.count]);
  if (hull.count < 3 || !(steepness(hull) < 1)) return;
  is_slab_ = true;
  corner_ = hull.ball[0].centre, radius_ = hull.ball[0].radius;
  const Vector3d e1 = hull.ball[1].centre - corner_, e2 = hull.ball[2].centre - corner_, across = e1.cross(e2);
  normal_ = across.normalized();
  weight1_ = e2.cross(across) / across.squaredNorm(), weight2_ = across.cross(e1) / across.squaredNorm();
  slope_ = (hull.ball[1].radius - radius_) * weight1_ + (hull.ball[2].radius - radius_) * weight2_;
  cosine_ = std::sqrt(1 - slope_.squaredNorm());
  shift_ = slope_ / cosine_;
}

double HullDistance::operator()(const Vector3d& p) const {
  if (is_slab_) {
    const Vector3d v = p - corner_;
    const double height = v.dot(normal_);
    const Vector3d foot = v - height * normal_ + std::abs(height) * shift_;
    const double w1 = weight1_.dot(foot), w2 = weight2_.dot(foot);
    if (w1 >= 0 && w2 >= 0 && w1 + w2 <= 1) return (v - foot).norm() - radius_ - slope_.dot(foot);
  }
  double nearest = side_[0].distance(p);
  for (std::size_t k = 1; k < sides_; ++k) nearest = std::min(nearest, side_[k].distance(p));
  return nearest;
}

}  // namespace spheretree::builder
