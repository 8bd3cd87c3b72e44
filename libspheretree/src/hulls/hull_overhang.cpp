// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/hull_overhang.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "spheretree/core/rounding.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// Part of a hull: the balls between these.
struct HullPiece {
  Hull hull;
  double bound;
  bool operator<(const HullPiece& other) const { return bound < other.bound; }
};

Ball middleOf(const Hull& hull) {
  Ball middle;
  for (std::size_t k = 0; k < hull.count; ++k) middle.centre += hull.ball[k].centre, middle.radius += hull.ball[k].radius;
  const auto count = static_cast<double>(hull.count);
  return {middle.centre / count, middle.radius / count};
}

class OverhangSearch {
 public:
  OverhangSearch(const DistanceField& field, const HullOverhangSettings& settings) : field_(field), settings_(settings) {}

  HullOverhang run(const Hull& hull) {
    for (std::size_t k = 0; k < hull.count; ++k) {
      attained_ = std::max(attained_, hull.ball[k].radius + field_.signedDistance(hull.ball[k].centre));
      if (attained_ > settings_.limit) return {attained_, kInfinity};
    }
    if (hull.count == 1) return {attained_, attained_};
    add(hull, kInfinity);
    std::size_t pieces = 1;
    while (attained_ <= settings_.limit && open_.front().bound > enough() && pieces < settings_.max_pieces) {
      std::pop_heap(open_.begin(), open_.end());
      const HullPiece next_piece = open_.back();
      const Hull& piece = next_piece.hull;
      open_.pop_back();
      std::size_t longest = 0;
      const auto length2 = [&](std::size_t k) { return (piece.ball[k].centre - piece.ball[(k + 1) % piece.count].centre).squaredNorm(); };
      for (std::size_t k = 1; k < piece.count; ++k)
        if (length2(k) > length2(longest)) longest = k;
      const std::size_t next = (longest + 1) % piece.count;
      const Ball &a = piece.ball[longest], &b = piece.ball[next];
      const Ball halfway{0.5 * (a.centre + b.centre), 0.5 * (a.radius + b.radius)};
      for (const std::size_t k : {longest, next}) {
        Hull half = piece;
        half.ball[k] = halfway;
        add(half, next_piece.bound);
      }
      pieces += 2;
    }
    return {attained_, std::max(attained_, open_.front().bound)};
  }

 private:
  double enough() const { return std::max({attained_ * (1 + settings_.relative), attained_ + settings_.absolute, settings_.accept}); }

  // With the centre m of the piece's middle ball at least h inside, where h is the largest distance of the piece's
  // centres from m, all of them are inside, and the overhang is the maximum over all triangles T of
  // r(w) - distance(c(w), T). T lies beyond the plane through its point q nearest to m, perpendicular to n = m - q.
  // The distance to that plane is linear, so that its bound is largest at a corner of the piece. A triangle farther
  // than the largest radius less `enough` from all centres has no say.
  void add(const Hull& hull, double bound) {
    const Ball middle = middleOf(hull);
    const double s = field_.signedDistance(middle.centre);
    attained_ = std::max(attained_, middle.radius + s);
    double reach = 0, lipschitz = 0, largest = 0;
    for (std::size_t k = 0; k < hull.count; ++k) {
      const double way = (hull.ball[k].centre - middle.centre).norm();
      reach = std::max(reach, way);
      lipschitz = std::max(lipschitz, hull.ball[k].radius + way);
      largest = std::max(largest, hull.ball[k].radius);
    }
    bound = std::min(bound, s + lipschitz);
    if (reach < -s) {
      const double accept = enough(), far = largest - accept + reach;
      double linear = accept;
      if (far > 0)
        field_.visitNear(middle.centre, far, [&](std::uint32_t triangle) {
          const auto [a, b, c] = field_.corners(triangle);
          const NearestPoint nearest = nearestOnTriangle(middle.centre, a, b, c);
          if (nearest.distance > far) return;
          const Vector3d n = (middle.centre - nearest.point) / nearest.distance;
          for (std::size_t k = 0; k < hull.count; ++k)
            linear = std::max(linear, hull.ball[k].radius - nearest.distance - n.dot(hull.ball[k].centre - middle.centre));
        });
      bound = std::min(bound, linear);
    }
    open_.push_back({hull, bound});
    std::push_heap(open_.begin(), open_.end());
  }

  const DistanceField& field_;
  const HullOverhangSettings& settings_;
  double attained_ = -kInfinity;
  std::vector<HullPiece> open_;  // a heap, the largest bound first
};

}  // namespace

HullOverhang hullOverhang(const DistanceField& field, const Hull& hull, HullOverhangSettings settings) {
  double rounding = field.diagonal();
  for (std::size_t k = 0; k < hull.count; ++k) rounding = std::max(rounding, hull.ball[k].centre.cwiseAbs().maxCoeff() + field.diagonal());
  settings.accept -= kRounding * rounding;
  HullOverhang out = OverhangSearch(field, settings).run(hull);
  out.bound += kRounding * rounding;
  return out;
}

}  // namespace spheretree::builder
