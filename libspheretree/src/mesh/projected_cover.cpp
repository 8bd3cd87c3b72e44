// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/projected_cover.h"

#include <algorithm>
#include <cmath>

namespace spheretree::builder {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinSlope = 0.1;         // smallest cosine between the normals: steeper triangles cover too little
constexpr double kWidening = 1e-11;       // as a share of the triangle's size: widening, so that rounding leaves no gaps between neighbours
constexpr double kMaxSlack = 0.01;        // largest share of the allowed distance that the widening may add
constexpr double kHeightRounding = 1e-9;  // margin for the rounding of the heights of cut corners
constexpr std::size_t kMaxParts = 512;    // parts of a triangle at any time; then the rest counts as not covered

using Polygon = std::vector<Vector2d>;  // convex

/// The inside is normal . p <= offset.
struct HalfPlane {
  Vector2d normal;
  double offset;
  double beyond(const Vector2d& p) const { return normal.dot(p) - offset; }
};

// The part on one side; the two parts together are the polygon.
Polygon clipped(const Polygon& polygon, const HalfPlane& half, bool keep_inside) {
  Polygon out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double a = half.beyond(p), b = half.beyond(q);
    if (keep_inside ? a <= 0 : a >= 0) out.push_back(p);
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) out.push_back(p + (a / (a - b)) * (q - p));
  }
  return out;
}

/// The plane of a triangle, with coordinates in it.
struct Frame {
  explicit Frame(const std::array<Vector3d, 3>& t) : origin(t[0]), x((t[1] - t[0]).normalized()) {
    z = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
    y = z.cross(x);
  }
  Vector2d flat(const Vector3d& p) const { return {x.dot(p - origin), y.dot(p - origin)}; }
  double height(const Vector3d& p) const { return z.dot(p - origin); }
  Vector3d back(const Vector2d& p) const { return origin + p.x() * x + p.y() * y; }
  Vector3d origin, x, y, z;
};

/// The part of the frame's plane that a triangle covers within a distance, and its distance from there.
struct Shadow {
  std::array<HalfPlane, 5> half;
  Vector2d slope;
  double level = 0;  // height above p: slope . p + level
  double slack = 0;  // increase of distances by the widening
  double heightOver(const Vector2d& p) const { return std::abs(slope.dot(p) + level); }
};

bool makeShadow(const std::array<Vector3d, 3>& corners, const Frame& frame, double size, double allowed, Shadow& shadow) {
  const Vector3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  const double along = n.dot(frame.z);
  if (!(std::abs(along) > kMinSlope)) return false;
  std::array<Vector2d, 3> p{frame.flat(corners[0]), frame.flat(corners[1]), frame.flat(corners[2])};
  shadow.slope = -Vector2d(n.dot(frame.x), n.dot(frame.y)) / along;
  shadow.level = frame.height(corners[0]) - shadow.slope.dot(p[0]);
  if (along < 0) std::swap(p[1], p[2]);  // counter-clockwise
  const double widening = kWidening * size;
  double smallest = 1;  // sine of the smallest angle
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector2d u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
    const double length = u.norm();
    if (!(length > 0 && v.norm() > 0)) return false;
    smallest = std::min(smallest, (u.x() * v.y() - u.y() * v.x()) / (length * v.norm()));
    const Vector2d out(u.y() / length, -u.x() / length);
    shadow.half[k] = {out, out.dot(p[k]) + widening};
  }
  // A widened corner of angle alpha is widening / sin(alpha / 2) beyond the original corner; in the triangle's own
  // plane, that distance is divided by the cosine of the slope.
  shadow.slack = 2 * widening / (smallest * kMinSlope);
  if (!(smallest > 0 && shadow.slack < kMaxSlack * allowed)) return false;
  const double height = (1 - kHeightRounding) * (allowed - shadow.slack);
  shadow.half[3] = {shadow.slope, height - shadow.level};
  shadow.half[4] = {-shadow.slope, height + shadow.level};
  return true;
}

}  // namespace

ProjectedCover coverByProjection(const std::array<Vector3d, 3>& triangle, const DistanceField& field, double allowed) {
  ProjectedCover out;
  const Frame frame(triangle);
  const Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
  double reach = 0;
  for (const Vector3d& p : triangle) reach = std::max(reach, (p - middle).norm());
  if (!frame.z.allFinite() || !(frame.z.squaredNorm() > 0.5)) return {0, {triangle}};
  std::vector<std::uint32_t> near;
  field.visitNear(middle, reach + allowed, [&](std::uint32_t t) { near.push_back(t); });
  std::sort(near.begin(), near.end());
  std::vector<Polygon> left{{frame.flat(triangle[0]), frame.flat(triangle[1]), frame.flat(triangle[2])}}, next;
  for (const std::uint32_t t : near) {
    if (left.empty() || left.size() > kMaxParts) break;
    Shadow shadow;
    if (!makeShadow(field.corners(t), frame, reach, allowed, shadow)) continue;
    next.clear();
    for (Polygon& whole : left) {
      Polygon rest = whole;
      std::vector<Polygon> beside;
      for (const HalfPlane& half : shadow.half) {
        if (Polygon outside = clipped(rest, half, false); outside.size() >= 3) beside.push_back(std::move(outside));
        rest = clipped(rest, half, true);
        if (rest.size() < 3) break;
      }
      if (rest.size() < 3) {
        next.push_back(std::move(whole));
        continue;
      }
      for (const Vector2d& p : rest) out.distance = std::max(out.distance, shadow.heightOver(p) + shadow.slack);
      next.insert(next.end(), beside.begin(), beside.end());
    }
    left.swap(next);
  }
  for (const Polygon& p : left)
    for (std::size_t k = 1; k + 1 < p.size(); ++k) out.not_covered.push_back({frame.back(p[0]), frame.back(p[k]), frame.back(p[k + 1])});
  return out;
}

}  // namespace spheretree::builder
