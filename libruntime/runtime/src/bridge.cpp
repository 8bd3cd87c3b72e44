// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/bridge.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "bridge_tree.h"
#include "flat_faces.h"
#include "probe_arcs.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

// Radii of probes, in medians of the leaves' radii.
constexpr double kOutside = 1e4;          // that rolls over the outside first: to it an object is as good as convex
constexpr double kProbes[] = {30, 0};     // that roll everywhere, from the largest down
constexpr int kMostRounds = 30;           // over the outside, with what stands out too far passed over
constexpr double kDeepestOutside = 1.03;  // pit below the hull, in overhangs: none is deeper, but cuts leave a little in doubt
constexpr int kMostCuts = 9;              // of a facet, to see that leaves hold all of it
constexpr double kLargest = 3;            // a part of a bridge, in medians of the leaves' radii: the search goes by balls about them
constexpr double kLevel = 0.125;          // tops that differ by less than this part of the overhang are of one height
constexpr double kBuried = 0.25;          // a top still shows if other leaves rise above it by less than this part of the deepest pit

struct Facet {
  Triple triple;
  Vector3d normal = Vector3d::Zero();  // none: no plane touches all three
  bool kept = false;
};

double wrapped(double angle) { return angle - kWholeTurn * std::round(angle / kWholeTurn); }

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
  /// Bridges rest on `leaves`, which may be levelled, and reach out of the true ones as far as they may.
  Builder(std::span<const Sphere> leaves, std::span<const Sphere> true_leaves, double overhang)
      : arcs_(leaves),
        leaves_(arcs_.leaves()),
        true_(true_leaves),
        tree_(arcs_.tree()),
        median_(arcs_.medianRadius()),
        overhang_(overhang),
        moved_(leaves.data() == true_leaves.data() ? 0 : kFarthestMove * kLevel * overhang) {}

  /// `is_uneven`: some leaves stand out farther than a bridge may. Those that the probe rests on without a new bridge are passed over and
  /// it rolls again, until it has come down to the others.
  /// Returns the planes of the facets that it found last.
  std::vector<Plane> rollOutside(bool is_uneven) {
    most_depth_ = kDeepestOutside * overhang_;
    bool again = true;
    std::vector<Facet> facets;
    for (int round = 0; again && round < kMostRounds; ++round) {
      facets = bridge(arcs_.ofTheOutside(kOutside * median_));
      std::vector<bool> is_bridged(leaves_.size(), !is_uneven);
      for (const Facet& f : facets)
        for (const std::uint32_t k : f.triple.leaf) is_bridged[k] = is_bridged[k] || f.kept;
      again = false;
      for (const Facet& f : facets)
        for (const std::uint32_t k : f.triple.leaf)
          if (!is_bridged[k]) {
            arcs_.passOver(k);
            again = true;
          }
    }
    std::vector<Plane> planes;
    for (const Facet& f : facets)
      if (f.kept) planes.push_back({f.normal, cornerOf(f, 0, 0).dot(f.normal)});
    return planes;
  }

  void roll(double probe) {
    most_depth_ = kDeepestPit * overhang_;
    bridge(arcs_.ofNeighbours(probe * median_));
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
  /// Adds the bridges of `arcs`; returns their facets, kept or not.
  std::vector<Facet> bridge(const std::vector<Arc>& arcs) {
    if (!facets_.bridges.empty()) kept_ = SphereGroups(facets_.around);
    const std::vector<Triple> before = triples_;
    std::vector<Facet> facets;
    for (const Arc& arc : arcs)
      for (std::size_t e = 0; e < 2; ++e)
        if (arc.end[e] != kNone) facets.push_back({arcs_.tripleAt(arc, e)});
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
      addFacet({leaves_[i], leaves_[j], leaves_[k]}, f.normal, found);
      triples_.push_back(f.triple);
    }
    std::sort(triples_.begin(), triples_.end());
    facets_.add(found);
    for (const Arc& arc : arcs) addCone(arc, facets);
    return facets;
  }

  static Sphere sphereOf(const Vector3d& c, double r) {
    return {static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()), static_cast<float>(r)};
  }

  Leaf trueLeaf(std::uint32_t k) const { return {{true_[k].x, true_[k].y, true_[k].z}, static_cast<double>(true_[k].radius)}; }
  const Leaf& leaf(const Facet& f, std::size_t k) const { return leaves_[f.triple.leaf[k]]; }
  Vector3d cornerOf(const Facet& f, std::size_t k, double depth) const { return leaf(f, k).c + (leaf(f, k).r - depth) * f.normal; }

  /// True if one leaf after the other holds all of the triangle.
  bool isHeld(const Vector3d& a, const Vector3d& b, const Vector3d& c, const std::vector<std::uint32_t>& by, int cuts) const {
    for (const std::uint32_t k : by) {
      const Leaf leaf = trueLeaf(k);
      const double r2 = leaf.r * leaf.r * (1 + 1e-9);
      const Vector3d& m = leaf.c;
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

  /// In parts that are not too large: cut at a ball halfway between two of its leaves, which touches the same plane.
  void addFacet(const std::array<Leaf, 3>& leaf, const Vector3d& normal, Found& found) const {
    std::array<Vector3d, 3> corner;
    for (std::size_t k = 0; k < 3; ++k) corner[k] = leaf[k].c + leaf[k].r * normal;
    const Sphere around = sphereAbout(corner, 0);
    if (static_cast<double>(around.radius) <= kLargest * median_) {
      found.bridges.push_back(bridgeOf(leaf[0], leaf[1], leaf[2], normal));
      found.around.push_back(around);
      return;
    }
    std::size_t longest = 0;
    const auto length = [&](std::size_t k) { return (corner[(k + 1) % 3] - corner[k]).squaredNorm(); };
    for (std::size_t k = 1; k < 3; ++k)
      if (length(k) > length(longest)) longest = k;
    const Leaf &a = leaf[longest], &b = leaf[(longest + 1) % 3], &c = leaf[(longest + 2) % 3], middle = between(a, b, 0.5);
    addFacet({a, middle, c}, normal, found);
    addFacet({middle, b, c}, normal, found);
  }
  static Leaf between(const Leaf& a, const Leaf& b, double s) { return {a.c + s * (b.c - a.c), a.r + s * (b.r - a.r)}; }

  static Bridge bridgeOf(const Leaf& a, const Leaf& b, const Leaf& c, const Vector3d& normal) {
    const Vector3d u = b.c - a.c, v = c.c - a.c, up = u.cross(v);
    // Weights at the foot, along the normal, of a point t: linear in t.
    const auto weight = [&](const Vector3d& along) -> Vector3d { return along - up * (normal.dot(along) / up.dot(normal)); };
    Bridge out{};
    put(out.a, a.c);
    out.radius = static_cast<float>(a.r);
    put(out.axis, normal);
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
        const Facet* const f = find(facets, arcs_.tripleAt(arc, e));
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
    const int parts = static_cast<int>(std::ceil(length / (2 * kLargest * median_)));
    for (int part = 0; part < parts; ++part) {
      const double s0 = double(part) / parts, s1 = double(part + 1) / parts;
      const Leaf first = between(a, b, s0);
      Bridge out{};
      put(out.a, first.c);
      out.radius = static_cast<float>(first.r);
      put(out.axis, axis);
      out.length = static_cast<float>(length / parts);
      out.u_extra = static_cast<float>(slope / rise);
      out.v_extra = static_cast<float>(rise);
      if (high - low < M_PI) {  // a wider one is not cut off: beyond its range facets lie above it
        put(out.u, arcs_.directionAt(arc, middle + low - M_PI / 2) * (parts / length));
        put(out.v, arcs_.directionAt(arc, middle + high + M_PI / 2) * (parts / length));
        const double half = (low + high) / 2;
        const std::array<Vector3d, 6> points{tangent(s0, low, 0),  tangent(s1, low, 0),  tangent(s0, high, 0),
                                             tangent(s1, high, 0), tangent(s0, half, 0), tangent(s1, half, 0)};
        cones_.around.push_back(sphereAbout(points, std::max(a.r, b.r) * (1 - std::cos((high - low) / 4))));
      } else {
        const std::array<Vector3d, 2> ends{first.c, between(a, b, s1).c};
        cones_.around.push_back(sphereAbout(ends, std::max(a.r, b.r)));
      }
      cones_.bridges.push_back(out);
    }
  }

  /// The same as for a facet, patch by patch.
  template <class Tangent>
  bool isShallow(const Arc& arc, const Tangent& tangent, double low, double high) const {
    const Leaf &a = leaves_[arc.i], &b = leaves_[arc.j];
    if (pairDepth(a, b) + moved_ <= most_depth_) return true;
    const double length = (b.c - a.c).norm(), depth = std::min({most_depth_, a.r, b.r});
    std::vector<std::uint32_t> by{arc.i, arc.j};
    tree_.visit(0.5 * (a.c + b.c), 0.5 * length + std::max(a.r, b.r), [&](std::uint32_t k) { by.push_back(k); });
    const auto held = [&](const auto& self, double s0, double s1, double a0, double a1, int cuts) -> bool {
      const std::array<Vector3d, 4> corner{tangent(s0, a0, depth), tangent(s0, a1, depth), tangent(s1, a0, depth), tangent(s1, a1, depth)};
      const double beyond = std::max(a.r, b.r) * (1 - std::cos(std::min(M_PI, (a1 - a0) / 2)));
      for (const std::uint32_t k : by) {
        const Leaf leaf = trueLeaf(k);
        const double r = leaf.r * (1 + 1e-9) - beyond;
        bool all = r > 0;
        for (const Vector3d& p : corner) all = all && (p - leaf.c).squaredNorm() <= r * r;
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

  ProbeArcs arcs_;
  const std::vector<Leaf>& leaves_;
  std::span<const Sphere> true_;
  const SphereGroups& tree_;  // of the leaves
  double median_, overhang_;
  double moved_;           // the leaves from the true ones, at most
  double most_depth_ = 0;  // of a pit below what is found now
  Found facets_, cones_;
  std::vector<Triple> triples_;  // of the facets, in order
  SphereGroups kept_;            // of the facets that larger probes found
};

}  // namespace

BridgeTree makeBridges(std::span<const Sphere> leaves, double overhang, bool is_uneven, const Eigen::Matrix3d& rotation) {
  if (!(overhang > 0)) return {};
  std::optional<Builder> builder(std::in_place, leaves, leaves, overhang);
  const std::vector<Plane> planes = builder->rollOutside(is_uneven);
  if (const std::vector<Sphere> flat = levelled(leaves, planes, kLevel * overhang); !flat.empty()) {
    builder.emplace(flat, leaves, overhang);
    builder->rollOutside(is_uneven);
  }
  for (const double probe : kProbes) builder->roll(probe);
  return builder->finish(rotation);
}

}  // namespace spheretree::runtime
