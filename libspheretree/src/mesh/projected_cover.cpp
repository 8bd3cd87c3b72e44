// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/projected_cover.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/ball.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// Far more than the rounding of a place in the plane of a triangle, as a share of the size of triangle and surface.
constexpr double kMargin = 1e-13;
constexpr double kMaxSlack = 0.01;  // largest share of the allowed distance that the margin may add

/// A triangle that lies in the plane z = 0 of its own frame, within margins of its sides. The frame is oblique: its
/// third axis is the direction of the projection, and z is the height over the plane.
class Flattened {
 public:
  Flattened(const std::array<Vector3d, 3>& triangle, const Vector3d& along, double rounding) : origin_(triangle[0]) {
    x_ = (triangle[1] - triangle[0]).normalized();
    z_ = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
    y_ = z_.cross(x_);
    const double rise = z_.dot(along);
    stretch_ = along.norm() / std::abs(rise);
    u_ = x_ - x_.dot(along) / rise * z_;
    v_ = y_ - y_.dot(along) / rise * z_;
    const double margin = margin_ = rounding * stretch_;
    for (std::size_t k = 0; k < 3; ++k) corner_[k] = inFrame(triangle[k]).head<2>();
    double perimeter = 0, smallest = 1;  // sine of the smallest angle
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector2d u = corner_[(k + 1) % 3] - corner_[k], v = corner_[(k + 2) % 3] - corner_[k];
      const double length = u.norm(), twice_area = u.x() * v.y() - u.y() * v.x();
      perimeter += length;
      smallest = std::min(smallest, twice_area / (length * v.norm()));
      normal_[k] = Eigen::Vector2d(u.y(), -u.x()) / length;
      inside_[k] = normal_[k].dot(corner_[k]) - 2 * margin;
      area_ = twice_area / 2;
    }
    // The sides move inward by twice the margin, and a corner of angle a by that divided by sin(a / 2).
    slack_ = 4 * margin / smallest;
    is_sound_ = smallest > 0 && 2 * margin * perimeter < area_ && std::isfinite(slack_);
  }

  bool isSound() const { return is_sound_; }
  double area() const { return area_; }
  /// A point over the plane is as far from its projection as this multiple of its height.
  double stretch() const { return stretch_; }
  /// No point of the triangle is farther from the part within the margins.
  double slack() const { return slack_; }
  Vector3d inFrame(const Vector3d& p) const { return {u_.dot(p - origin_), v_.dot(p - origin_), z_.dot(p - origin_)}; }
  Vector3d ofPlane(const Vector3d& in_frame) const { return origin_ + in_frame.x() * x_ + in_frame.y() * y_; }
  /// Distance beyond side k of the part within the margins.
  double beyond(std::size_t k, const Vector3d& in_frame) const { return normal_[k].dot(in_frame.head<2>()) - inside_[k]; }
  /// Whether a side from `a` to `b` (and their distances beyond) is certainly outside the part within the margins:
  /// beyond one of its sides, or with all of it on one side.
  bool isOutside(const Vector3d& a, const std::array<double, 3>& a_beyond, const Vector3d& b, const std::array<double, 3>& b_beyond) const {
    for (std::size_t k = 0; k < 3; ++k)
      if (a_beyond[k] >= margin_ && b_beyond[k] >= margin_) return true;
    const Eigen::Vector2d along = (b - a).head<2>();
    const double least = margin_ * along.norm();
    int left = 0, right = 0;
    for (const Eigen::Vector2d& c : corner_) {
      const double height = along.x() * (c.y() - a.y()) - along.y() * (c.x() - a.x());
      left += height > least, right += height < -least;
    }
    return left == 3 || right == 3;
  }

 private:
  Vector3d origin_, x_, y_, z_;
  Vector3d u_, v_;  // their products with a place are the coordinates of its projection
  std::array<Eigen::Vector2d, 3> corner_, normal_;
  std::array<double, 3> inside_{};
  double margin_ = 0, stretch_ = 1, area_ = 0, slack_ = 0;
  bool is_sound_ = false;
};

/// A convex polygon of at most six corners, each with its distances beyond the sides.
class Polygon {
 public:
  struct Corner {
    Vector3d p;
    std::array<double, 3> beyond;
  };
  explicit Polygon(const std::array<Corner, 3>& triangle) { std::copy(triangle.begin(), triangle.end(), corner_.begin()); }

  void clip(std::size_t side) {
    const std::array<Corner, 7> before = corner_;
    const std::size_t n = count_;
    count_ = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const Corner &from = before[i], &to = before[i + 1 == n ? 0 : i + 1];
      const double a = from.beyond[side], b = to.beyond[side];
      if (a <= 0) corner_[count_++] = from;
      if ((a < 0 && b > 0) || (a > 0 && b < 0)) {
        const double t = a / (a - b);
        Corner& cut = corner_[count_++];
        cut.p = from.p + t * (to.p - from.p);
        for (std::size_t k = 0; k < 3; ++k) cut.beyond[k] = from.beyond[k] + t * (to.beyond[k] - from.beyond[k]);
        cut.beyond[side] = 0;
      }
    }
  }
  double area() const {
    double twice = 0;
    for (std::size_t i = 2; i < count_; ++i) {
      const Vector3d u = corner_[i - 1].p - corner_[0].p, v = corner_[i].p - corner_[0].p;
      twice += u.x() * v.y() - u.y() * v.x();
    }
    return twice / 2;
  }
  const Corner* begin() const { return corner_.data(); }
  const Corner* end() const { return corner_.data() + count_; }

 private:
  std::array<Corner, 7> corner_;
  std::size_t count_ = 3;
};

}  // namespace

double ProjectedCover::distance(const std::array<Vector3d, 3>& triangle, const Vector3d& along, std::uint32_t start, double floor,
                                double allowed) {
  farthest_.reset();
  double size = field_.diagonal();
  for (std::size_t k = 1; k < 3; ++k) size = std::max(size, (triangle[k] - triangle[0]).norm());
  const Flattened whole(triangle, along, kMargin * size);
  if (!whole.isSound() || whole.slack() > kMaxSlack * allowed) return kInfinity;
  allowed -= whole.slack();
  double farthest = 0, area = 0;
  if (++search_ == 0) std::fill(met_.begin(), met_.end(), 0), search_ = 1;
  to_do_.assign(1, start);
  met_[start] = search_;
  while (!to_do_.empty()) {
    const std::uint32_t t = to_do_.back();
    to_do_.pop_back();
    const std::array<Vector3d, 3> face = field_.corners(t);
    std::array<Polygon::Corner, 3> corner;
    for (std::size_t j = 0; j < 3; ++j) {
      corner[j].p = whole.inFrame(face[j]);
      for (std::size_t k = 0; k < 3; ++k) corner[j].beyond[k] = whole.beyond(k, corner[j].p);
    }
    for (std::size_t j = 0; j < 3; ++j) {
      const Polygon::Corner &a = corner[j], &b = corner[(j + 1) % 3];
      if (whole.isOutside(a.p, a.beyond, b.p, b.beyond)) continue;
      const std::uint32_t next = field_.across(t, j);
      if (next == DistanceField::kNoTriangle) return kInfinity;
      if (met_[next] == search_) continue;
      met_[next] = search_;
      to_do_.push_back(next);
    }
    Polygon over(corner);
    for (std::size_t k = 0; k < 3; ++k)
      if (corner[0].beyond[k] > 0 || corner[1].beyond[k] > 0 || corner[2].beyond[k] > 0) over.clip(k);
    area += over.area();
    for (const Polygon::Corner& c : over) {
      const double most = std::abs(c.p.z()) * whole.stretch();
      if (most <= std::max(farthest, floor)) {
        farthest = std::max(farthest, most);
        continue;
      }
      const Vector3d at = whole.ofPlane(c.p);
      const double distance = nearestOnTriangle(at, face[0], face[1], face[2]).distance;
      if (distance <= farthest) continue;
      farthest = distance;
      farthest_ = at;
      if (farthest > allowed) return kInfinity;
    }
  }
  return std::abs(area) > 0.5 * whole.area() ? farthest + whole.slack() : kInfinity;
}

}  // namespace spheretree::builder
