// SPDX-License-Identifier: Apache-2.0
#include "scene/compiled_hulls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace spheretree::runtime {
namespace {

constexpr double kBulge = 2;  // largest way from the axis of a cone to the felt axis, as a multiple of the bound of the overhang

Sphere minus(const Sphere& a, const Sphere& b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.radius - b.radius}; }

using Direction = Eigen::Vector4d;  // of an axis, and how the radius grows along it

// An end of a cone: the direction from there is of unit length but for the fourth component.
struct ConeEnd {
  std::size_t part, end;
  Direction away;
  double length;
};

// How far the felt axis would be from the straight ones if `b` continued `a`: as a circle with both as chords.
double bulgeOf(const ConeEnd& a, const ConeEnd& b) {
  const double cosine = -a.away.head<3>().dot(b.away.head<3>());
  return cosine > 0 ? std::max(a.length, b.length) * std::acos(std::min(cosine, 1.0)) / 8 : std::numeric_limits<double>::infinity();
}

// The ends of cones at each ball.
std::vector<std::vector<ConeEnd>> coneEnds(const Hulls& hulls) {
  std::vector<std::vector<ConeEnd>> ends(hulls.balls.size());
  for (std::size_t i = 0; i < hulls.parts.size(); ++i) {
    const HullPart& part = hulls.parts[i];
    if (ballCount(part) != 2) continue;
    const Sphere &a = hulls.balls[part[0]], &b = hulls.balls[part[1]];
    Direction way;
    way << centreOf(b) - centreOf(a), double{b.radius} - double{a.radius};
    const double length = way.head<3>().norm();
    ends[part[0]].push_back({i, 0, way / length, length});
    ends[part[1]].push_back({i, 1, -way / length, length});
  }
  return ends;
}

const ConeEnd* nextOf(const ConeEnd& end, const std::vector<ConeEnd>& ends, double largest) {
  const ConeEnd* next = nullptr;
  for (const ConeEnd& other : ends)
    if (const double bulge = bulgeOf(end, other); bulge <= largest) next = &other, largest = bulge;
  return next;
}

// Where one cone continues another, both get the direction between theirs, so that what is felt of them has no corner.
struct FeltDirections {
  std::vector<std::array<Sphere, 2>> turn;  // (part) at both ends: the felt direction, as long as the axis, minus the axis
  std::vector<bool> joins;                  // (ball)
  explicit FeltDirections(const Hulls& hulls) : turn(hulls.parts.size()), joins(hulls.balls.size()) {
    const std::vector<std::vector<ConeEnd>> ends = coneEnds(hulls);
    for (std::size_t ball = 0; ball < ends.size(); ++ball)
      for (const ConeEnd& end : ends[ball]) {
        const double largest = kBulge * double{hulls.overhang_bound};
        const ConeEnd* const next = nextOf(end, ends[ball], largest);
        if (!next || nextOf(*next, ends[ball], largest) != &end) continue;
        joins[ball] = true;
        Direction felt = end.away - next->away;
        felt /= felt.head<3>().norm();
        const Eigen::Vector4f change = (end.length * (end.end == 0 ? 1 : -1) * (felt - end.away)).cast<float>();
        turn[end.part][end.end] = {change[0], change[1], change[2], change[3]};
      }
  }
};

}  // namespace

CompiledHulls compileHulls(const Hulls& hulls, const Eigen::Vector3d& origin) {
  CompiledHulls out;
  if (hulls.empty()) return out;
  std::vector<Sphere> spheres;
  for (const HullPart& part : hulls.parts) spheres.push_back(enclose(hulls, part));
  out.tree = compileTree(hulls.search, spheres, origin, TreeOver::Triangles);
  out.ways_apart = static_cast<std::uint32_t>(out.tree.item.size());
  out.span1 = out.span2 = out.turn0 = out.turn1 = std::vector<Sphere>(3 * out.ways_apart);
  const FeltDirections felt(hulls);
  for (std::uint32_t way = 0; way < 3; ++way)
    for (std::uint32_t slot = 0; slot < out.ways_apart; ++slot) {
      const Block& block = out.tree.bound[slot / 8];
      out.way.push_back(way);
      out.ball.push_back({block.x[slot % 8], block.y[slot % 8], block.z[slot % 8], block.r[slot % 8]});
      if (out.tree.item[slot] == kNoItem) continue;
      const HullPart& part = hulls.parts[out.tree.item[slot]];
      out.turn0[out.way.size() - 1] = felt.turn[out.tree.item[slot]][0];
      out.turn1[out.way.size() - 1] = felt.turn[out.tree.item[slot]][1];
      if (ballCount(part) == 1 && felt.joins[part[0]]) out.way.back() = kNoFeltWay;
      const Sphere& first = hulls.balls[part[0]];
      const Eigen::Vector3f at = (centreOf(first) + origin).cast<float>();
      out.ball.back() = {at.x(), at.y(), at.z(), first.radius};
      if (part[1] != kNoHullBall) out.span1[slot + way * out.ways_apart] = minus(hulls.balls[part[1]], first);
      if (part[2] != kNoHullBall) out.span2[slot + way * out.ways_apart] = minus(hulls.balls[part[2]], first);
    }
  out.smallest_radius = std::ranges::min_element(hulls.balls, {}, &Sphere::radius)->radius;
  return out;
}

}  // namespace spheretree::runtime
