// SPDX-License-Identifier: Apache-2.0
#include "scene/compiled_hulls.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spheretree::runtime {
namespace {

constexpr double kBulge = 2;  // largest way from the axis of a cone to the felt axis, as a multiple of the bound of the overhang

Sphere minus(const Sphere& a, const Sphere& b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.radius - b.radius}; }

// An end of a cone.
struct ConeEnd {
  std::size_t number;    // of the part, times 2, plus 1 at its ball 1
  Eigen::Vector3d away;  // unit direction of the axis from there
  double length, radius;
  const ConeEnd* next = nullptr;  // of the cone that continues this one

  // How far the felt axis would be from the straight ones if `other` continued this cone: as a circle with both as
  // chords.
  double bulgeWith(const ConeEnd& other, double bound) const {
    const double cosine = -away.dot(other.away);
    if (!(cosine > 0) || std::abs(radius - other.radius) > bound) return std::numeric_limits<double>::infinity();
    return std::max(length, other.length) * std::acos(std::min(cosine, 1.0)) / 8;
  }
};

// Where one cone continues another, both get the direction and the radius between theirs, so that what is felt of them
// has no corner.
class FeltCones {
 public:
  explicit FeltCones(const Hulls& hulls)
      : turn(2 * hulls.parts.size()), swell(turn.size()), hulls_(hulls), ends_(hulls.balls.size()), joined_(ends_.size()) {
    for (std::size_t i = 0; i < hulls.parts.size(); ++i) {
      const HullPart& part = hulls.parts[i];
      if (ballCount(part) != 2) continue;
      const Sphere &a = hulls.balls[part[0]], &b = hulls.balls[part[1]];
      const Eigen::Vector3d way = centreOf(b) - centreOf(a);
      const double length = way.norm();
      ends_[firstAt(a)].push_back({2 * i, way / length, length, double{a.radius}});
      ends_[firstAt(b)].push_back({2 * i + 1, -way / length, length, double{b.radius}});
    }
    for (std::size_t at = 0; at < ends_.size(); ++at) join(at);
    for (const auto& ends : ends_)
      for (const ConeEnd& end : ends)
        if (end.next) bend(end);
  }

  /// A cone continues another at the centre of this ball, and no smaller ball.
  bool holds(const Sphere& ball) const { return double{ball.radius} <= joined_[firstAt(ball)]; }

  // CompiledHulls::bend of a part. A cubic axis with the turns t at its ends is within max |t| / 4 of the straight one.
  float bendOf(std::size_t part) const {
    const Sphere &a = turn[2 * part], &b = turn[2 * part + 1];
    const auto turns = static_cast<float>(std::max(centreOf(a).norm(), centreOf(b).norm()));
    return turns + std::max(std::abs(a.radius), std::abs(b.radius)) +
           2 * std::max(std::abs(swell[2 * part]), std::abs(swell[2 * part + 1]));
  }

  // (two for each part, one for each end) Felt direction and growth of the radius, for the length of the axis, minus
  // those of the axis between the felt balls; the felt radius minus the radius.
  std::vector<Sphere> turn;
  std::vector<float> swell;

 private:
  // Number of the first ball with this centre.
  std::size_t firstAt(const Sphere& ball) const {
    std::size_t i = 0;
    while (hulls_.balls[i].x != ball.x || hulls_.balls[i].y != ball.y || hulls_.balls[i].z != ball.z) ++i;
    return i;
  }

  const ConeEnd* nearest(const ConeEnd& end, const std::vector<ConeEnd>& ends) const {
    const ConeEnd* next = nullptr;
    double least = kBulge * double{hulls_.overhang_bound};
    for (const ConeEnd& other : ends)
      if (const double bulge = end.bulgeWith(other, double{hulls_.overhang_bound}); bulge <= least) next = &other, least = bulge;
    return next;
  }

  void join(std::size_t at) {
    for (ConeEnd& end : ends_[at]) {
      const ConeEnd* const next = nearest(end, ends_[at]);
      if (!next || nearest(*next, ends_[at]) != &end) continue;
      end.next = next;
      swell[end.number] = static_cast<float>((next->radius - end.radius) / 2);
      joined_[at] = std::max(joined_[at], end.radius);
    }
  }

  // How the felt radius grows from the end, for each length of the axis.
  double growth(const ConeEnd& end) const {
    const HullPart& part = hulls_.parts[end.number / 2];
    const double rise = double{hulls_.balls[part[1]].radius} + double{swell[end.number | 1]} - double{hulls_.balls[part[0]].radius} -
                        double{swell[end.number & ~std::size_t{1}]};
    return (end.number % 2 == 0 ? rise : -rise) / end.length;
  }

  void bend(const ConeEnd& end) {
    const double scale = end.number % 2 == 0 ? end.length : -end.length;
    const Eigen::Vector3f change = (scale * ((end.away - end.next->away).normalized() - end.away)).cast<float>();
    turn[end.number] = {change[0], change[1], change[2], static_cast<float>(-scale * (growth(end) + growth(*end.next)) / 2)};
  }

  const Hulls& hulls_;
  std::vector<std::vector<ConeEnd>> ends_;  // at the first ball of each centre
  std::vector<double> joined_;              // likewise, the larger radius of the cones that continue each other
};

}  // namespace

CompiledHulls compileHulls(const Hulls& hulls, const Eigen::Vector3d& origin) {
  CompiledHulls out;
  if (hulls.empty()) return out;
  std::vector<Sphere> spheres;
  for (const HullPart& part : hulls.parts) spheres.push_back(enclose(hulls, part));
  out.tree = compileTree(hulls.search, spheres, origin, TreeOver::Triangles);
  out.ways_apart = static_cast<std::uint32_t>(out.tree.item.size());
  out.ball = out.span1 = out.span2 = out.turn0 = out.turn1 = std::vector<Sphere>(3 * out.ways_apart);
  out.swell.resize(out.ball.size());
  out.bend.resize(out.ball.size());
  out.way.resize(out.ball.size());
  const FeltCones felt(hulls);
  for (std::uint32_t at = 0; at < out.ball.size(); ++at) {
    const std::uint32_t slot = at % out.ways_apart, item = out.tree.item[slot];
    const Block& block = out.tree.bound[slot / 8];
    out.way[at] = at / out.ways_apart;
    out.ball[at] = {block.x[slot % 8], block.y[slot % 8], block.z[slot % 8], block.r[slot % 8]};
    if (item == kNoItem) continue;
    const HullPart& part = hulls.parts[item];
    out.turn0[at] = felt.turn[2 * item];
    out.turn1[at] = felt.turn[2 * item + 1];
    out.swell[at] = {felt.swell[2 * item], felt.swell[2 * item + 1]};
    out.bend[at] = felt.bendOf(item);
    const Sphere& first = hulls.balls[part[0]];
    if (ballCount(part) == 1 && felt.holds(first)) out.way[at] = kNoFeltWay;
    const Eigen::Vector3f centre = (centreOf(first) + origin).cast<float>();
    out.ball[at] = {centre.x(), centre.y(), centre.z(), first.radius};
    if (part[1] != kNoHullBall) out.span1[at] = minus(hulls.balls[part[1]], first);
    if (part[2] != kNoHullBall) out.span2[at] = minus(hulls.balls[part[2]], first);
  }
  out.smallest_radius = std::ranges::min_element(hulls.balls, {}, &Sphere::radius)->radius;
  return out;
}

}  // namespace spheretree::runtime
