// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/projected_cover.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "base/ball.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kMinSlope = 0.1;         // smallest cosine between the normals: steeper triangles cover too little
constexpr double kWidening = 1e-11;       // as a share of the triangle's size: widening, so that rounding leaves no gaps between neighbours
constexpr double kMaxSlack = 0.01;        // largest share of the allowed distance that the widening may add
constexpr double kHeightRounding = 1e-9;  // margin for the rounding of the heights of cut corners
constexpr std::size_t kMaxParts = 512;    // parts of a region at any time; then the rest counts as not covered
constexpr std::size_t kFewShadows = 6;    // a region with at most this number of shadows is not divided
constexpr double kMinGain = 0.75;         // largest share of the shadows that may reach into one half of a divided region

using Polygon = std::vector<Vector2d>;  // convex

/// The inside is normal . p <= offset.
struct HalfPlane {
  Vector2d normal;
  double offset;
  double beyond(const Vector2d& p) const { return normal.dot(p) - offset; }
  template <class Points>
  bool excludes(const Points& points) const {
    return std::all_of(points.begin(), points.end(), [&](const Vector2d& p) { return beyond(p) >= 0; });
  }
};

// The part on one side; the two parts together are the polygon.
Polygon clipped(const Polygon& polygon, const HalfPlane& half, bool keep_inside) {
  Polygon out;
  out.reserve(polygon.size() + 1);
  Vector2d p = polygon.back();
  double a = half.beyond(p);
  for (const Vector2d& q : polygon) {
    const double b = half.beyond(q);
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) out.push_back(p + (a / (a - b)) * (q - p));
    if (keep_inside ? b <= 0 : b >= 0) out.push_back(q);
    p = q, a = b;
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
  std::uint32_t triangle;
  std::array<Vector2d, 3> corner;  // counter-clockwise
  std::array<HalfPlane, 5> half;
  Vector2d slope;
  double level = 0;  // height above p: slope . p + level
  double slack = 0;  // increase of distances by the widening
  Vector2d across;   // perpendicular to the longest side, y >= 0
  double angle = 0;  // ascends with the angle of `across`
  double heightOver(const Vector2d& p) const { return std::abs(slope.dot(p) + level); }
  bool misses(const Polygon& region) const {
    return std::any_of(half.begin(), half.end(), [&](const HalfPlane& side) { return side.excludes(region); });
  }
};

bool makeShadow(const std::array<Vector3d, 3>& corners, const Frame& frame, double size, double allowed, Shadow& shadow) {
  const Vector3d n = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
  const double along = n.dot(frame.z);
  if (!(std::abs(along) > kMinSlope)) return false;
  std::array<Vector2d, 3>& p = shadow.corner;
  shadow.slope = -Vector2d(n.dot(frame.x), n.dot(frame.y)) / along;
  shadow.level = frame.height(corners[0]) - shadow.slope.dot(p[0]);
  if (along < 0) std::swap(p[1], p[2]);
  const double widening = kWidening * size;
  double smallest = 1;  // sine of the smallest angle
  double longest = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector2d u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
    const double length = u.norm();
    if (!(length > 0 && v.norm() > 0)) return false;
    smallest = std::min(smallest, (u.x() * v.y() - u.y() * v.x()) / (length * v.norm()));
    const Vector2d out(u.y() / length, -u.x() / length);
    shadow.half[k] = {out, out.dot(p[k]) + widening};
    if (length > longest) longest = length, shadow.across = out.y() < 0 ? Vector2d(-out) : out, shadow.angle = -shadow.across.x();
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

/// Subtracts shadows from a triangle. A region with many shadows is divided, and each half meets only the shadows that
/// reach into it.
class Subtraction {
 public:
  Subtraction(const std::array<Vector3d, 3>& triangle, const DistanceField& field, double allowed, double reach, ProjectedCover& out)
      : field_(field), frame_(triangle), out_(out) {
    const Polygon whole{frame_.flat(triangle[0]), frame_.flat(triangle[1]), frame_.flat(triangle[2])};
    std::array<HalfPlane, 3> side;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector2d u = whole[(k + 1) % 3] - whole[k], outward(u.y(), -u.x());
      side[k] = {outward, outward.dot(whole[k])};
    }
    std::vector<std::uint32_t> near;
    field.visitNear((triangle[0] + triangle[1] + triangle[2]) / 3, reach + allowed, [&](std::uint32_t t) {
      const std::array<Vector2d, 3> corner = flattened(field.corners(t));
      if (std::none_of(side.begin(), side.end(), [&](const HalfPlane& half) { return half.excludes(corner); })) near.push_back(t);
    });
    std::sort(near.begin(), near.end());
    for (const std::uint32_t t : near) {
      Shadow shadow;
      shadow.triangle = t;
      shadow.corner = flattened(field.corners(t));
      if (makeShadow(field.corners(t), frame_, reach, allowed, shadow)) shadows_.push_back(shadow);
    }
    std::vector<std::uint32_t> all;
    for (std::uint32_t s = 0; s < shadows_.size(); ++s)
      if (!shadows_[s].misses(whole)) all.push_back(s);
    run(whole, all);
  }

 private:
  struct Cut {
    HalfPlane half;
    std::size_t larger = 0;  // number of shadows that reach into the half with more of them
  };
  struct Range {
    double low = kInfinity, high = -kInfinity;
    void add(double at) { low = std::min(low, at), high = std::max(high, at); }
  };

  std::array<Vector2d, 3> flattened(const std::array<Vector3d, 3>& corners) const {
    return {frame_.flat(corners[0]), frame_.flat(corners[1]), frame_.flat(corners[2])};
  }

  template <class Points>
  static Range rangeOf(const Points& points, const Vector2d& direction) {
    Range range;
    for (const Vector2d& p : points) range.add(direction.dot(p));
    return range;
  }

  // NOLINTNEXTLINE(misc-no-recursion): the number of shadows falls by kMinGain with each level.
  void run(const Polygon& region, const std::vector<std::uint32_t>& shadows) {
    if (shadows.size() > kFewShadows) {
      const Cut cut = bestCut(region, shadows);
      if (static_cast<double>(cut.larger) <= kMinGain * static_cast<double>(shadows.size())) {
        std::vector<std::uint32_t> reaching;
        for (const bool inside : {true, false}) {
          const Polygon part = clipped(region, cut.half, inside);
          if (part.size() < 3) continue;
          reaching.clear();
          for (const std::uint32_t s : shadows)
            if (reachesInto(shadows_[s], cut.half, inside) && !shadows_[s].misses(part)) reaching.push_back(s);
          run(part, reaching);
        }
        return;
      }
    }
    subtract(region, shadows);
  }

  /// Shadows that only touch the cut count on their own side alone: of a fan around a point of the cut, each half keeps
  /// half.
  static bool reachesInto(const Shadow& shadow, const HalfPlane& half, bool inside) {
    const Range range = rangeOf(shadow.corner, half.normal);
    return inside ? range.low < half.offset : range.high > half.offset;
  }

  /// The cut at the median of the ends of the shadows, along the axes of the frame or across their longest sides, since
  /// slivers lie side by side, or around a point.
  Cut bestCut(const Polygon& region, const std::vector<std::uint32_t>& shadows) {
    ordered_ = shadows;
    const auto middle = ordered_.begin() + static_cast<std::ptrdiff_t>(ordered_.size() / 2);
    std::nth_element(ordered_.begin(), middle, ordered_.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return std::pair(shadows_[a].angle, a) < std::pair(shadows_[b].angle, b); });
    Cut best{{Vector2d::UnitX(), 0}, shadows.size()};
    for (const Vector2d& direction : std::array<Vector2d, 3>{Vector2d::UnitX(), Vector2d::UnitY(), shadows_[*middle].across}) {
      const Range within = rangeOf(region, direction);
      ends_.clear();
      for (const std::uint32_t s : shadows) {
        const Range range = rangeOf(shadows_[s].corner, direction);
        ends_.push_back(std::max(range.low, within.low));
        ends_.push_back(std::min(range.high, within.high));
      }
      const auto median = ends_.begin() + static_cast<std::ptrdiff_t>(ends_.size() / 2);
      std::nth_element(ends_.begin(), median, ends_.end());
      const HalfPlane half{direction, *median};
      std::array<std::size_t, 2> reaching{};
      for (const std::uint32_t s : shadows)
        for (const bool inside : {true, false}) reaching[inside] += reachesInto(shadows_[s], half, inside);
      const std::size_t larger = std::max(reaching[0], reaching[1]);
      if (larger < best.larger) best = {half, larger};
    }
    return best;
  }

  /// The nearest shadow first: where several cover a point, the distance is that of the first.
  void subtract(const Polygon& region, const std::vector<std::uint32_t>& shadows) {
    const Vector2d middle = std::accumulate(region.begin(), region.end(), Vector2d(Vector2d::Zero())) / static_cast<double>(region.size());
    nearest_.clear();
    for (const std::uint32_t s : shadows) nearest_.emplace_back(shadows_[s].heightOver(middle), s);
    std::sort(nearest_.begin(), nearest_.end());
    left_.assign(1, region);
    for (const auto& [height, s] : nearest_) {
      if (left_.empty() || left_.size() > kMaxParts) break;
      const Shadow& shadow = shadows_[s];
      next_.clear();
      for (Polygon& whole : left_) {
        if (shadow.misses(whole)) {
          next_.push_back(std::move(whole));
          continue;
        }
        Polygon rest = whole;
        beside_.clear();
        for (const HalfPlane& half : shadow.half) {
          if (std::all_of(rest.begin(), rest.end(), [&](const Vector2d& p) { return half.beyond(p) <= 0; })) continue;
          if (Polygon outside = clipped(rest, half, false); outside.size() >= 3) beside_.push_back(std::move(outside));
          rest = clipped(rest, half, true);
          if (rest.size() < 3) break;
        }
        if (rest.size() < 3) {
          next_.push_back(std::move(whole));
          continue;
        }
        for (const Vector2d& p : rest)
          if (shadow.heightOver(p) + shadow.slack > out_.distance) out_.distance = std::max(out_.distance, distanceOf(p, shadow));
        std::move(beside_.begin(), beside_.end(), std::back_inserter(next_));
      }
      left_.swap(next_);
    }
    for (const Polygon& p : left_)
      for (std::size_t k = 1; k + 1 < p.size(); ++k)
        out_.not_covered.push_back({frame_.back(p[0]), frame_.back(p[k]), frame_.back(p[k + 1])});
  }

  /// The distance from one triangle is convex, so over a polygon it is largest at a corner.
  double distanceOf(const Vector2d& p, const Shadow& shadow) const {
    const auto [a, b, c] = field_.corners(shadow.triangle);
    return nearestOnTriangle(frame_.back(p), a, b, c).distance;
  }

  const DistanceField& field_;
  Frame frame_;
  ProjectedCover& out_;
  std::vector<Shadow> shadows_;
  std::vector<double> ends_;
  std::vector<std::uint32_t> ordered_;
  std::vector<std::pair<double, std::uint32_t>> nearest_;
  std::vector<Polygon> left_, next_, beside_;
};

}  // namespace

ProjectedCover coverByProjection(const std::array<Vector3d, 3>& triangle, const DistanceField& field, double allowed) {
  ProjectedCover out;
  const Vector3d middle = (triangle[0] + triangle[1] + triangle[2]) / 3;
  double reach = 0;
  for (const Vector3d& p : triangle) reach = std::max(reach, (p - middle).norm());
  const Vector3d z = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
  if (!z.allFinite() || !(z.squaredNorm() > 0.5)) return {0, {triangle}};
  Subtraction(triangle, field, allowed, reach, out);
  return out;
}

}  // namespace spheretree::builder
