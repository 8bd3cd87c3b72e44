// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/bridge.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "bridge_tree.h"
#include "free_arcs.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

constexpr double kProbes[] = {30, 0};  // radii of the probes, in medians of the leaves' radii, from the largest down
constexpr int kMostCuts = 9;           // of a facet, to see that leaves hold all of it
constexpr double kWidest = 2;          // a bridge joins leaves if the pit between two alone is no deeper than this many deepest pits
constexpr double kBuried = 0.25;       // a top still shows if other leaves rise above it by less than this part of the deepest pit

struct Leaf {
  Vector3d c;
  double r;
};

/// A part of the circle on which a probe touches two leaves, free of all others, with the leaves that end it; kNone: the whole circle.
struct Arc {
  std::uint32_t i, j;
  std::array<std::uint32_t, 2> end;
  std::array<double, 2> angle;  // about the axis from i to j, from `across`
  Vector3d across;
};

/// Three leaves that a probe touches, in order, and the side of their plane on which it is.
struct Triple {
  std::array<std::uint32_t, 3> leaf;
  bool above;
  auto operator<=>(const Triple&) const = default;
};

struct Facet {
  Triple triple;
  Vector3d normal = Vector3d::Zero();  // none: no plane touches all three
  bool kept = false;
};

double wrapped(double angle) { return angle - kWholeTurn * std::round(angle / kWholeTurn); }

Vector3d axisOf(const Leaf& a, const Leaf& b) { return (b.c - a.c).normalized(); }

/// How high the cone about two balls that overlap stands above the circle in which they meet.
double pairDepth(const Leaf& a, const Leaf& b) {
  const double length = (b.c - a.c).norm(), slope = (a.r - b.r) / length;
  const double along = 0.5 * (length + (a.r * a.r - b.r * b.r) / length), high = std::sqrt(std::max(0.0, a.r * a.r - along * along));
  return a.r - (slope * along + std::sqrt(std::max(0.0, 1 - slope * slope)) * high);
}

/// Unit normal of the plane that touches three balls from the side of `up`, the normal of the plane of centres; none if one is too small.
std::optional<Vector3d> touchingPlane(const Leaf& a, const Leaf& b, const Leaf& c, bool above) {
  const Vector3d u = b.c - a.c, v = c.c - a.c, up = u.cross(v);
  const double area2 = up.squaredNorm();
  if (!(area2 > 1e-12 * u.squaredNorm() * v.squaredNorm())) return std::nullopt;
  // n in the plane of centres solves n.u = ra - rb, n.v = ra - rc.
  const Vector3d in_plane = ((a.r - b.r) * v.cross(up) + (a.r - c.r) * up.cross(u)) / area2;
  const double rest = 1 - in_plane.squaredNorm();
  if (!(rest > 1e-4)) return std::nullopt;
  return in_plane + up * ((above ? 1 : -1) * std::sqrt(rest / area2));
}

/// Bridges, and a sphere that holds all of each.
struct Found {
  std::vector<Bridge> bridges;
  std::vector<Sphere> around;
  void add(const Found& more) {
    bridges.insert(bridges.end(), more.bridges.begin(), more.bridges.end());
    around.insert(around.end(), more.around.begin(), more.around.end());
  }
};

/// The bridges of one object, found probe by probe.
class Builder {
 public:
  Builder(std::span<const Sphere> leaves, double most_depth) : most_depth_(most_depth), tree_(leaves) {
    std::vector<double> radii;
    for (const Sphere& s : leaves) {
      leaves_.push_back({{s.x, s.y, s.z}, static_cast<double>(s.radius)});
      radii.push_back(leaves_.back().r);
    }
    std::nth_element(radii.begin(), radii.begin() + static_cast<std::ptrdiff_t>(radii.size() / 2), radii.end());
    median_ = radii[radii.size() / 2];
    neighbours_.resize(leaves_.size());
    std::vector<std::pair<double, std::uint32_t>> order;
    for (std::uint32_t i = 0; i < leaves_.size(); ++i) {
      order.clear();
      tree_.visit(leaves_[i].c, leaves_[i].r, [&](std::uint32_t j) {
        const double inside = leaves_[i].r - leaves_[j].r;
        if (j != i && (leaves_[i].c - leaves_[j].c).squaredNorm() > inside * inside)
          order.push_back({pairDepth(leaves_[i], leaves_[j]), j});
      });
      std::sort(order.begin(), order.end());
      for (const auto& [depth, j] : order) {
        neighbours_[i].push_back(j);
        if (i < j && !isWide(i, j)) pairs_.push_back({i, j});
      }
    }
  }

  void roll(double probe) {
    if (!facets_.bridges.empty()) kept_ = SphereGroups(facets_.around);
    const std::vector<Triple> before = triples_;
    std::vector<Arc> arcs = freeArcs(pairs_, probe * median_);
    std::vector<Facet> facets;
    for (const Arc& arc : arcs)
      for (std::size_t e = 0; e < 2; ++e)
        if (arc.end[e] != kNone) facets.push_back({tripleOf(arc, e)});
    std::sort(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) { return a.triple < b.triple; });
    facets.erase(std::unique(facets.begin(), facets.end(), [](const Facet& a, const Facet& b) { return a.triple == b.triple; }),
                 facets.end());
    Found found;
    for (Facet& f : facets) {
      const auto& [i, j, k] = f.triple.leaf;
      const std::optional<Vector3d> n = touchingPlane(leaves_[i], leaves_[j], leaves_[k], f.triple.above);
      if (!n) continue;
      f.normal = *n;
      if (std::binary_search(before.begin(), before.end(), f.triple) || isBuried(f) || !isExposed(f) || !isShallow(f)) continue;
      f.kept = true;
      found.bridges.push_back(bridgeOf(f));
      found.around.push_back(sphereAround(f));
      triples_.push_back(f.triple);
    }
    std::sort(triples_.begin(), triples_.end());
    facets_.add(found);
    for (const Arc& arc : freeArcs(wideSides(facets), probe * median_)) arcs.push_back(arc);
    for (const Arc& arc : arcs) addCone(arc, facets);
  }

  BridgeTree finish(const Eigen::Matrix3d& rotation) {
    facets_.add(cones_);
    if (facets_.bridges.size() > kMostBridges) {
      facets_.bridges.resize(kMostBridges);
      facets_.around.resize(kMostBridges);
    }
    for (Bridge& b : facets_.bridges)
      for (float* const v : {b.a, b.axis, b.u, b.v}) put(v, rotation * vector(v));
    for (Sphere& s : facets_.around) s = sphereOf(rotation * Vector3d(s.x, s.y, s.z), s.radius);
    return treeOf(facets_.bridges, facets_.around);
  }

 private:
  using Pair = std::pair<std::uint32_t, std::uint32_t>;

  static Sphere sphereOf(const Vector3d& c, double r) {
    return {static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()), static_cast<float>(r)};
  }

  bool isWide(std::uint32_t i, std::uint32_t j) const { return pairDepth(leaves_[i], leaves_[j]) >= kWidest * most_depth_; }

  /// Sides of kept facets that are not among the pairs to be bridged: without the cone about it there would be a slit along the side.
  std::vector<Pair> wideSides(const std::vector<Facet>& facets) const {
    std::vector<Pair> sides;
    for (const Facet& f : facets) {
      const auto& [a, b, c] = f.triple.leaf;
      for (const auto& [i, j] : {Pair(a, b), Pair(a, c), Pair(b, c)})
        if (f.kept && isWide(i, j)) sides.emplace_back(i, j);
    }
    std::sort(sides.begin(), sides.end());
    sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
    return sides;
  }

  /// Of the pairs of leaves, the parts of the circle where a probe of radius `probe` rests on both and on no other nearby.
  std::vector<Arc> freeArcs(const std::vector<Pair>& pairs, double probe) const {
    std::vector<Arc> arcs;
    FreeArcs left;
    for (const auto& [i, j] : pairs) addArcs(i, j, probe, left, arcs);
    return arcs;
  }

  void addArcs(std::uint32_t i, std::uint32_t j, double probe, FreeArcs& left, std::vector<Arc>& arcs) const {
    const Leaf &a = leaves_[i], &b = leaves_[j];
    const double ra = a.r + probe, rb = b.r + probe, length = (b.c - a.c).norm();
    const double along = 0.5 * (length + (ra * ra - rb * rb) / length), rho2 = ra * ra - along * along;
    if (!(rho2 > 1e-12 * ra * ra)) return;
    const Vector3d axis = (b.c - a.c) / length, middle = a.c + along * axis, e1 = axis.unitOrthogonal(), e2 = axis.cross(e1);
    left.start();
    const auto take = [&](std::uint32_t k) {
      if (k == i || k == j) return;
      const Vector3d w = leaves_[k].c - middle;
      const double x = w.dot(e1), y = w.dot(e2), off2 = x * x + y * y, rk = leaves_[k].r + probe;
      const double q = rho2 + w.squaredNorm() - rk * rk, scale2 = 4 * rho2 * off2;
      if (q * q >= scale2) {  // the circle is all outside or all inside
        if (q < 0) left.clear();
        return;
      }
      // From the direction (x, y) of the leaf the arc reaches as far to either side as its cosine says.
      const double c = q / std::sqrt(scale2), s = std::sqrt(1 - c * c);
      left.take(squareAngle(x * c + y * s, y * c - x * s), squareAngle(x * c - y * s, y * c + x * s), k);
    };
    for (const std::uint32_t k : neighbours_[b.r < a.r ? j : i]) {  // the first of them hide most circles
      take(k);
      if (left.empty()) return;
    }
    for (const FreeArcs::Piece& p : left.whole())
      arcs.push_back({i, j, {p.low_end, p.high_end}, {trueAngle(p.low), trueAngle(p.high)}, e1});
  }

  Vector3d directionAt(const Arc& arc, double angle) const {
    return arc.across * std::cos(angle) + axisOf(leaves_[arc.i], leaves_[arc.j]).cross(arc.across) * std::sin(angle);
  }

  Triple tripleOf(const Arc& arc, std::size_t e) const {
    Triple t{{arc.i, arc.j, arc.end[e]}, false};
    std::sort(t.leaf.begin(), t.leaf.end());
    const Vector3d& a = leaves_[t.leaf[0]].c;
    const Vector3d up = (leaves_[t.leaf[1]].c - a).cross(leaves_[t.leaf[2]].c - a);
    // At its end the probe is on the side to which the arc's direction points, against the third leaf.
    const Vector3d third = leaves_[arc.end[e]].c - leaves_[arc.i].c, axis = axisOf(leaves_[arc.i], leaves_[arc.j]);
    const Vector3d towards = third - axis * axis.dot(third), normal = axis.cross(towards);
    t.above = directionAt(arc, arc.angle[e]).dot(normal) * up.dot(normal) > 0;
    return t;
  }

  const Leaf& leaf(const Facet& f, std::size_t k) const { return leaves_[f.triple.leaf[k]]; }
  Vector3d cornerOf(const Facet& f, std::size_t k, double depth) const { return leaf(f, k).c + (leaf(f, k).r - depth) * f.normal; }

  /// True if one leaf after the other holds all of the triangle.
  bool isHeld(const Vector3d& a, const Vector3d& b, const Vector3d& c, const std::vector<std::uint32_t>& by, int cuts) const {
    for (const std::uint32_t k : by) {
      const double r2 = leaves_[k].r * leaves_[k].r * (1 + 1e-9);
      const Vector3d& m = leaves_[k].c;
      if ((a - m).squaredNorm() <= r2 && (b - m).squaredNorm() <= r2 && (c - m).squaredNorm() <= r2) return true;
    }
    if (cuts == 0) return false;
    const Vector3d ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    return isHeld(ab, bc, ca, by, cuts - 1) && isHeld(a, ab, ca, by, cuts - 1) && isHeld(ab, b, bc, by, cuts - 1) &&
           isHeld(ca, bc, c, by, cuts - 1);
  }

  /// No pit below is deeper than it may be.
  bool isShallow(const Facet& f) const {
    const double depth = std::min({most_depth_, leaf(f, 0).r, leaf(f, 1).r, leaf(f, 2).r});
    const Vector3d a = cornerOf(f, 0, depth), b = cornerOf(f, 1, depth), c = cornerOf(f, 2, depth), m = (a + b + c) / 3;
    const double reach = std::sqrt(std::max({(a - m).squaredNorm(), (b - m).squaredNorm(), (c - m).squaredNorm()}));
    std::vector<std::uint32_t> by(f.triple.leaf.begin(), f.triple.leaf.end());
    if (isHeld(a, b, c, by, 2)) return true;
    tree_.visit(m, reach, [&](std::uint32_t k) { by.push_back(k); });
    return isHeld(a, b, c, by, kMostCuts);
  }

  /// It touches what shows of its leaves. One across a valley, or to a leaf farther up a wall, touches them deep inside others.
  bool isExposed(const Facet& f) const {
    bool exposed = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d touch = cornerOf(f, k, 0);
      tree_.visit(touch, 0, [&](std::uint32_t other) {
        exposed = exposed && leaves_[other].r - (leaves_[other].c - touch).norm() < kBuried * most_depth_;
      });
    }
    return exposed;
  }

  /// Below facets that larger probes found.
  bool isBuried(const Facet& f) const {
    const Vector3d a = cornerOf(f, 0, 0), b = cornerOf(f, 1, 0), c = cornerOf(f, 2, 0), m = (a + b + c) / 3;
    for (const Vector3d& p : {Vector3d((a + b) / 2), Vector3d((b + c) / 2), Vector3d((c + a) / 2), a, b, c}) {
      bool below = false;
      const Vector3d at = p + 0.05 * (m - p);
      kept_.visit(at, 1e-6 * median_, [&](std::uint32_t k) { below = below || isBelow(facets_.bridges[k], at); });
      if (!below) return false;
    }
    return true;
  }
  bool isBelow(const Bridge& bridge, const Vector3d& p) const {
    const Vector3d t = p - vector(bridge.a);
    const double u = vector(bridge.u).dot(t), v = vector(bridge.v).dot(t),
                 gap = vector(bridge.axis).dot(t) - static_cast<double>(bridge.radius);
    return u > -0.01 && v > -0.01 && u + v < 1.01 && gap < 1e-4 * median_ && gap > -most_depth_;
  }

  Bridge bridgeOf(const Facet& f) const {
    const Leaf &a = leaf(f, 0), &b = leaf(f, 1), &c = leaf(f, 2);
    const Vector3d u = b.c - a.c, v = c.c - a.c, up = u.cross(v);
    // Weights at the foot, along the normal, of a point t: linear in t.
    const auto weight = [&](const Vector3d& along) -> Vector3d { return along - up * (f.normal.dot(along) / up.dot(f.normal)); };
    Bridge out{};
    put(out.a, a.c);
    out.radius = static_cast<float>(a.r);
    put(out.axis, f.normal);
    put(out.u, weight(v.cross(up) / up.squaredNorm()));
    put(out.v, weight(up.cross(u) / up.squaredNorm()));
    out.u_extra = static_cast<float>(b.r - a.r);
    out.v_extra = static_cast<float>(c.r - a.r);
    return out;
  }
  static Vector3d vector(const float* v) { return {v[0], v[1], v[2]}; }
  static void put(float* to, const Vector3d& v) {
    for (int k = 0; k < 3; ++k) to[k] = static_cast<float>(v[k]);
  }

  /// About all points of a facet, or of the part of a cone.
  template <std::size_t kCount>
  Sphere sphereAbout(const std::array<Vector3d, kCount>& points, double beyond) const {
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : points) box.extend(p);
    const Vector3d m = box.center();
    double r = 0;
    for (const Vector3d& p : points) r = std::max(r, (p - m).norm());
    return sphereOf(m, 1.001 * (r + beyond) + 1e-6 * (m.norm() + r));
  }
  Sphere sphereAround(const Facet& f) const {
    const std::array<Vector3d, 3> corner{cornerOf(f, 0, 0), cornerOf(f, 1, 0), cornerOf(f, 2, 0)};
    return sphereAbout(corner, 0);
  }

  static const Facet* find(const std::vector<Facet>& facets, const Triple& triple) {
    const auto at = std::lower_bound(facets.begin(), facets.end(), triple, [](const Facet& f, const Triple& t) { return f.triple < t; });
    return at != facets.end() && at->triple == triple ? &*at : nullptr;
  }

  /// The cone over `arc`, between its two facets, of which one was kept; over a whole circle as well.
  void addCone(const Arc& arc, const std::vector<Facet>& facets) {
    const Leaf &a = leaves_[arc.i], &b = leaves_[arc.j];
    const double length = (b.c - a.c).norm(), slope = (a.r - b.r) / length;
    if (!(std::abs(slope) < 0.99)) return;
    const double rise = std::sqrt(1 - slope * slope);
    const Vector3d axis = (b.c - a.c) / length, other = axis.cross(arc.across);
    const bool whole = arc.end[0] == kNone;
    const double middle = 0.5 * (arc.angle[0] + arc.angle[1]);
    double low = -M_PI, high = M_PI;  // of the cone, about the middle of the arc
    if (!whole) {
      bool wanted = false;
      for (std::size_t e = 0; e < 2; ++e) {
        const Facet* const f = find(facets, tripleOf(arc, e));
        double at = arc.angle[e];
        if (f && f->normal.squaredNorm() > 0) at = std::atan2(f->normal.dot(other), f->normal.dot(arc.across));
        wanted = wanted || (f && f->kept);
        (e == 0 ? low : high) = wrapped(at - middle);
      }
      if (!wanted || !(low < high)) return;  // where the facets meet in a valley there is nothing between them
    }
    const auto tangent = [&](double s, double angle, double depth) -> Vector3d {
      const Vector3d normal = axis * slope + (arc.across * std::cos(middle + angle) + other * std::sin(middle + angle)) * rise;
      return a.c + axis * (s * length) + (a.r + s * (b.r - a.r) - depth) * normal;
    };
    if (!isShallow(arc, tangent, low, high)) return;
    Bridge out{};
    put(out.a, a.c);
    out.radius = static_cast<float>(a.r);
    put(out.axis, axis);
    out.length = static_cast<float>(length);
    out.u_extra = static_cast<float>(slope / rise);
    out.v_extra = static_cast<float>(rise);
    if (high - low < M_PI) {  // a wider one is not cut off: beyond its range facets lie above it
      put(out.u, directionAt(arc, middle + low - M_PI / 2) / length);
      put(out.v, directionAt(arc, middle + high + M_PI / 2) / length);
      const std::array<Vector3d, 6> points{tangent(0, low, 0),
                                           tangent(1, low, 0),
                                           tangent(0, high, 0),
                                           tangent(1, high, 0),
                                           tangent(0, (low + high) / 2, 0),
                                           tangent(1, (low + high) / 2, 0)};
      cones_.around.push_back(sphereAbout(points, std::max(a.r, b.r) * (1 - std::cos((high - low) / 4))));
    } else {
      const std::array<Vector3d, 2> ends{a.c, b.c};
      cones_.around.push_back(sphereAbout(ends, std::max(a.r, b.r)));
    }
    cones_.bridges.push_back(out);
  }

  /// The same as for a facet, patch by patch.
  template <class Tangent>
  bool isShallow(const Arc& arc, const Tangent& tangent, double low, double high) const {
    const Leaf &a = leaves_[arc.i], &b = leaves_[arc.j];
    if (pairDepth(a, b) <= most_depth_) return true;
    const double length = (b.c - a.c).norm(), depth = std::min({most_depth_, a.r, b.r});
    std::vector<std::uint32_t> by{arc.i, arc.j};
    tree_.visit(0.5 * (a.c + b.c), 0.5 * length + std::max(a.r, b.r), [&](std::uint32_t k) { by.push_back(k); });
    const auto held = [&](const auto& self, double s0, double s1, double a0, double a1, int cuts) -> bool {
      const std::array<Vector3d, 4> corner{tangent(s0, a0, depth), tangent(s0, a1, depth), tangent(s1, a0, depth), tangent(s1, a1, depth)};
      const double beyond = std::max(a.r, b.r) * (1 - std::cos(std::min(M_PI, (a1 - a0) / 2)));
      for (const std::uint32_t k : by) {
        const double r = leaves_[k].r * (1 + 1e-9) - beyond;
        bool all = r > 0;
        for (const Vector3d& p : corner) all = all && (p - leaves_[k].c).squaredNorm() <= r * r;
        if (all) return true;
      }
      if (cuts == 0) return false;
      if ((a1 - a0) * std::max(a.r, b.r) > (s1 - s0) * length) {
        const double m = 0.5 * (a0 + a1);
        return self(self, s0, s1, a0, m, cuts - 1) && self(self, s0, s1, m, a1, cuts - 1);
      }
      const double m = 0.5 * (s0 + s1);
      return self(self, s0, m, a0, a1, cuts - 1) && self(self, m, s1, a0, a1, cuts - 1);
    };
    return held(held, 0, 1, low, high, 9);
  }

  double most_depth_, median_ = 0;
  std::vector<Leaf> leaves_;
  SphereGroups tree_;                                   // of the leaves
  std::vector<std::vector<std::uint32_t>> neighbours_;  // that overlap, the one with the shallowest pit between first
  std::vector<Pair> pairs_;                             // to be bridged
  Found facets_, cones_;
  std::vector<Triple> triples_;  // of the facets, in order
  SphereGroups kept_;            // of the facets that larger probes found
};

}  // namespace

BridgeTree makeBridges(std::span<const Sphere> leaves, double overhang, const Eigen::Matrix3d& rotation) {
  if (!(overhang > 0)) return {};
  Builder builder(leaves, kDeepestPit * overhang);
  for (const double probe : kProbes) builder.roll(probe);
  return builder.finish(rotation);
}

}  // namespace spheretree::runtime
