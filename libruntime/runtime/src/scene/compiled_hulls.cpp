// SPDX-License-Identifier: Apache-2.0
#include "scene/compiled_hulls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

namespace spheretree::runtime {
namespace {

constexpr double kBulge = 2;  // largest way from the axis of a cone to the felt axis, as a multiple of the bound of the overhang

Sphere minus(const Sphere& a, const Sphere& b) { return {a.x - b.x, a.y - b.y, a.z - b.z, a.radius - b.radius}; }

// An end of a cone.
struct ConeEnd {
  std::size_t part, end;
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
  explicit FeltCones(const Hulls& hulls) : turn(hulls.parts.size()), swell(hulls.parts.size()) {
    for (std::size_t i = 0; i < hulls.parts.size(); ++i) {
      const HullPart& part = hulls.parts[i];
      if (ballCount(part) != 2) continue;
      const Sphere &a = hulls.balls[part[0]], &b = hulls.balls[part[1]];
      const Eigen::Vector3d way = centreOf(b) - centreOf(a);
      ends_[{a.x, a.y, a.z}].push_back({i, 0, way.normalized(), way.norm(), double{a.radius}});
      ends_[{b.x, b.y, b.z}].push_back({i, 1, -way.normalized(), way.norm(), double{b.radius}});
    }
    for (auto& [centre, ends] : ends_) join(centre, ends, double{hulls.overhang_bound});
    for (const auto& [centre, ends] : ends_)
      for (const ConeEnd& end : ends)
        if (end.next) bend(hulls, end);
  }

  bool areBeside(const Sphere& ball) const {
    const auto at = joined_.find({ball.x, ball.y, ball.z});
    return at != joined_.end() && double{ball.radius} <= at->second;
  }

  // (part) at both ends: the felt direction and growth of the radius, for the length of the axis, minus that of the
  // axis between the felt balls; the felt radius minus the radius.
  std::vector<std::array<Sphere, 2>> turn;
  std::vector<std::array<float, 2>> swell;

 private:
  using Centre = std::array<float, 3>;

  static const ConeEnd* nearest(const ConeEnd& end, const std::vector<ConeEnd>& ends, double bound) {
    const auto bulge = [&](const ConeEnd& other) { return end.bulgeWith(other, bound); };
    const auto next = std::ranges::min_element(ends, {}, bulge);
    return bulge(*next) <= kBulge * bound ? &*next : nullptr;
  }

  void join(const Centre& centre, std::vector<ConeEnd>& ends, double bound) {
    for (ConeEnd& end : ends) {
      const ConeEnd* const next = nearest(end, ends, bound);
      if (!next || nearest(*next, ends, bound) != &end) continue;
      end.next = next;
      swell[end.part][end.end] = static_cast<float>((next->radius - end.radius) / 2);
      double& largest = joined_[centre];
      largest = std::max(largest, end.radius);
    }
  }

  // How the felt radius grows from the end, for each length of the axis.
  double growth(const Hulls& hulls, const ConeEnd& end) const {
    const auto radius = [&](std::size_t k) { return double{hulls.balls[hulls.parts[end.part][k]].radius} + double{swell[end.part][k]}; };
    return (radius(1 - end.end) - radius(end.end)) / end.length;
  }

  void bend(const Hulls& hulls, const ConeEnd& end) {
    const Eigen::Vector3d felt = (end.away - end.next->away).normalized();
    const double scale = end.end == 0 ? end.length : -end.length, own = growth(hulls, end);
    const Eigen::Vector3f change = (scale * (felt - end.away)).cast<float>();
    turn[end.part][end.end] = {change[0], change[1], change[2], static_cast<float>(-scale * (own + growth(hulls, *end.next)) / 2)};
  }

  std::map<Centre, std::vector<ConeEnd>> ends_;
  std::map<Centre, double> joined_;  // the larger radius
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
  out.swell.resize(out.span1.size());
  const FeltCones felt(hulls);
  for (std::uint32_t way = 0; way < 3; ++way)
    for (std::uint32_t slot = 0; slot < out.ways_apart; ++slot) {
      const Block& block = out.tree.bound[slot / 8];
      out.way.push_back(way);
      out.ball.push_back({block.x[slot % 8], block.y[slot % 8], block.z[slot % 8], block.r[slot % 8]});
      if (out.tree.item[slot] == kNoItem) continue;
      const HullPart& part = hulls.parts[out.tree.item[slot]];
      out.turn0[out.way.size() - 1] = felt.turn[out.tree.item[slot]][0];
      out.turn1[out.way.size() - 1] = felt.turn[out.tree.item[slot]][1];
      out.swell[out.way.size() - 1] = felt.swell[out.tree.item[slot]];
      if (ballCount(part) == 1 && felt.areBeside(hulls.balls[part[0]])) out.way.back() = kNoFeltWay;
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
