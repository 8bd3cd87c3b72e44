// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/swept_surface.h"

#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numeric>
#include <string>
#include <unordered_set>
#include <vector>

#include "spheretree/builder/build_settings.h"
#include "spheretree/core/rounding.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr int kLevels = 19;           // halvings of the root cube: the sums of two coordinates, of which three make a name, have 21 bits
constexpr double kLeastShare = 1e-3;  // of its edge, between a corner and the end: a corner at the end makes a flat triangle
// Share of the box by which the root cube begins before it. It ends as far behind it or farther, so that planes of an
// object at round numbers are none of the lattice, whose corners would be as near to them as rounding.
constexpr double kRootShift = 0.08;
constexpr std::size_t kMaxTetrahedra = 2'000'000;

/// Corners and the number of the one with which the first corner makes the edge that is bisected [Maubach 1995].
struct Tetrahedron {
  std::array<Vector3i, 4> corner;
  std::uint8_t far = 3;
  std::vector<std::uint32_t> nearby;  // capsules that may meet it

  /// Of the middle of the edge to bisect.
  Vector3i middle() const { return (corner[0] + corner[far]) / 2; }
};

/// The points of a cut tetrahedron: those in the swept space, and those outside, each with the points on the edges.
struct Parts {
  unsigned in = 0;  // (corner) bits
  std::array<Vector3d, 8> inner, outer;
  std::size_t inner_count = 0, outer_count = 0;
};

std::uint64_t nameOf(const Vector3i& doubled) {
  std::uint64_t name = 0;
  for (const int coordinate : doubled) name = name << (kLevels + 2) | static_cast<std::uint64_t>(coordinate);
  return name;
}

class Sweep {
 public:
  Sweep(std::span<const Capsule> capsules, double tolerance);

  std::vector<Tetrahedron> tetrahedra(Progress& progress);
  TriangleMesh surface(std::span<const Tetrahedron> tetrahedra) const;

 private:
  enum class State : char { Empty, Proven, Open };

  Vector3d at(const Vector3i& point) const { return origin_ + unit_ * point.cast<double>(); }
  double distance(std::uint32_t k, const Vector3d& p) const { return (p - nearestOnAxis(capsules_[k], p)).norm() - capsules_[k].radius; }
  bool isIn(const Vector3d& p, const Tetrahedron& t) const {
    return std::any_of(t.nearby.begin(), t.nearby.end(), [&](std::uint32_t k) { return distance(k, p) < 0; });
  }
  Vector3d crossing(const Vector3d& in, const Vector3d& out, const Tetrahedron& t) const;
  Parts partsOf(const Tetrahedron& t) const;
  State examine(Tetrahedron& t) const;
  bool isProven(const Parts& parts, const Tetrahedron& t) const;
  bool hasPointOnEdge(const Tetrahedron& t) const;
  void bisect(const Tetrahedron& t, std::vector<Tetrahedron>& out);

  std::span<const Capsule> capsules_;
  double tolerance_, unit_ = 0;
  Vector3d origin_;
  std::unordered_set<std::uint64_t> points_;  // where edges were bisected
};

Sweep::Sweep(std::span<const Capsule> capsules, double tolerance) : capsules_(capsules), tolerance_(tolerance) {
  Eigen::AlignedBox3d box;
  for (const Capsule& c : capsules)
    for (const Vector3d& p : {c.from, c.to}) box.extend(Eigen::AlignedBox3d(p.array() - c.radius, p.array() + c.radius));
  const double size = box.sizes().maxCoeff();
  unit_ = std::ldexp((1 + kRootShift) * (1 + kRootShift) * size, -kLevels);
  origin_ = box.min().array() - kRootShift * size;
}

/// A point of the boundary between a point of the swept space and one outside.
Vector3d Sweep::crossing(const Vector3d& in, const Vector3d& out, const Tetrahedron& t) const {
  double low = 0, high = 1;  // share of the way
  while (high - low > kLeastShare * kLeastShare) {
    const double middle = (low + high) / 2;
    (isIn(in + middle * (out - in), t) ? low : high) = middle;
  }
  return in + std::clamp((low + high) / 2, kLeastShare, 1 - kLeastShare) * (out - in);
}

Parts Sweep::partsOf(const Tetrahedron& t) const {
  Parts out;
  std::array<Vector3d, 4> corner;
  for (unsigned k = 0; k < 4; ++k) {
    corner[k] = at(t.corner[k]);
    const bool is_in = isIn(corner[k], t);
    out.in |= static_cast<unsigned>(is_in) << k;
    (is_in ? out.inner[out.inner_count++] : out.outer[out.outer_count++]) = corner[k];
  }
  for (unsigned a = 0; a < 4; ++a)
    for (unsigned b = 0; b < 4; ++b)
      if (out.in >> a & ~out.in >> b & 1) out.inner[out.inner_count++] = out.outer[out.outer_count++] = crossing(corner[a], corner[b], t);
  return out;
}

/// A capsule, enlarged by the tolerance, is convex: it contains the inner part if it contains its points. Shrunk by the
/// tolerance it misses the outer part if a plane lies between them.
bool Sweep::isProven(const Parts& parts, const Tetrahedron& t) const {
  const double rounding = kRounding * std::ldexp(unit_, kLevels);
  const std::span inner(parts.inner.data(), parts.inner_count), outer(parts.outer.data(), parts.outer_count);
  const auto containsInner = [&](std::uint32_t k) {
    return std::all_of(inner.begin(), inner.end(), [&](const Vector3d& p) { return distance(k, p) <= tolerance_ - rounding; });
  };
  if (!inner.empty() && std::none_of(t.nearby.begin(), t.nearby.end(), containsInner)) return false;
  if (outer.empty()) return true;
  const Vector3d middle = std::accumulate(outer.begin(), outer.end(), Vector3d(Vector3d::Zero())) / static_cast<double>(outer.size());
  return std::all_of(t.nearby.begin(), t.nearby.end(), [&](std::uint32_t k) {
    const Capsule& capsule = capsules_[k];
    const Vector3d normal = (middle - nearestOnAxis(capsule, middle)).normalized();
    const double reach = std::max(normal.dot(capsule.from), normal.dot(capsule.to)) + capsule.radius - tolerance_ + rounding;
    return std::all_of(outer.begin(), outer.end(), [&](const Vector3d& p) { return normal.dot(p) >= reach; });
  });
}

/// Whether the boundary may meet it, and if so, whether what it holds is proven to be within the tolerance.
Sweep::State Sweep::examine(Tetrahedron& t) const {
  std::array<Vector3d, 4> corner;
  std::transform(t.corner.begin(), t.corner.end(), corner.begin(), [&](const Vector3i& p) { return at(p); });
  const Vector3d middle = (corner[0] + corner[1] + corner[2] + corner[3]) / 4;
  double radius = 0, longest = 0;
  for (const Vector3d& p : corner) {
    radius = std::max(radius, (p - middle).norm());
    for (const Vector3d& q : corner) longest = std::max(longest, (p - q).norm());
  }
  double nearest = std::numeric_limits<double>::infinity();
  std::erase_if(t.nearby, [&](std::uint32_t k) {
    const double here = distance(k, middle);
    nearest = std::min(nearest, here);
    return here > radius;
  });
  if (std::abs(nearest) > radius) return State::Empty;
  // The points of its inner part are combinations of points of the swept space, no farther from each other than the
  // longest edge, but for kLeastShare of it. By Jung's theorem one of these is within sqrt(3/8) of that length.
  const bool is_small = (std::sqrt(3.0 / 8) + kLeastShare) * longest <= tolerance_;
  return is_small || isProven(partsOf(t), t) ? State::Proven : State::Open;
}

bool Sweep::hasPointOnEdge(const Tetrahedron& t) const {
  for (std::size_t a = 0; a < 4; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (points_.contains(nameOf(t.corner[a] + t.corner[b]))) return true;
  return false;
}

void Sweep::bisect(const Tetrahedron& t, std::vector<Tetrahedron>& out) {
  points_.insert(nameOf(t.corner[0] + t.corner[t.far]));
  const Vector3i middle = t.middle();
  const auto far = static_cast<std::uint8_t>(t.far > 1 ? t.far - 1 : 3);
  Tetrahedron first{t.corner, far, t.nearby}, second{t.corner, far, t.nearby};
  first.corner[t.far] = middle;
  for (std::size_t k = 0; k < t.far; ++k) second.corner[k] = t.corner[k + 1];
  second.corner[t.far] = middle;
  out.push_back(std::move(first));
  out.push_back(std::move(second));
}

/// Those that the boundary may meet. No corner of one lies on an edge of another.
std::vector<Tetrahedron> Sweep::tetrahedra(Progress& progress) {
  std::vector<Tetrahedron> open, done;
  std::array<int, 3> axes{0, 1, 2};
  do {  // of the root cube
    Tetrahedron& t = open.emplace_back();
    t.corner[0].setZero();
    for (std::size_t k = 0; k < 3; ++k) t.corner[k + 1] = t.corner[k] + (1 << kLevels) * Vector3i::Unit(axes[k]);
    t.nearby.resize(capsules_.size());
    std::iota(t.nearby.begin(), t.nearby.end(), 0u);
  } while (std::next_permutation(axes.begin(), axes.end()));
  while (!open.empty()) {
    std::vector<State> state(open.size());
    tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t i) {
      if (!progress.cancelled()) state[i] = examine(open[i]);
    });
    progress.check();
    std::vector<Tetrahedron> next;
    for (std::size_t i = 0; i < open.size(); ++i) {
      if (state[i] == State::Proven) done.push_back(std::move(open[i]));
      if (state[i] != State::Open) continue;
      if ((open[i].corner[0] + open[i].corner[open[i].far]).unaryExpr([](int c) { return c & 1; }).any())
        throw BuildError("the tolerance is too small for an object of this size. Give a larger one.");
      bisect(open[i], next);
    }
    if (next.empty()) {
      std::vector<Tetrahedron> kept;
      for (Tetrahedron& t : done) hasPointOnEdge(t) ? bisect(t, next) : kept.push_back(std::move(t));
      done = std::move(kept);
    }
    if (done.size() + next.size() > kMaxTetrahedra)
      throw BuildError("the surface of what was cut is too large for this tolerance. Give a larger one.");
    open = std::move(next);
  }
  return done;
}

/// An even permutation of the corners of a tetrahedron that has those of the set `in` first.
std::array<std::size_t, 4> inFirst(unsigned in) {
  std::array<std::size_t, 4> order{0, 1, 2, 3};
  std::stable_partition(order.begin(), order.end(), [&](std::size_t k) { return in >> k & 1; });
  bool is_odd = false;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) is_odd = is_odd != (order[i] > order[j]);
  const std::size_t first = std::popcount(in) == 1 ? 2 : 0;  // one of two neighbours on the same side
  if (is_odd) std::swap(order[first], order[first + 1]);
  return order;
}

TriangleMesh Sweep::surface(std::span<const Tetrahedron> tetrahedra) const {
  struct Corner {
    std::uint64_t name;
    Vector3d position;
  };
  struct Cut {
    std::array<Corner, 4> corners;
    std::size_t count = 0;  // of corners
  };
  std::vector<Cut> pieces(tetrahedra.size());
  tbb::parallel_for(std::size_t{0}, tetrahedra.size(), [&](std::size_t i) {
    Tetrahedron t = tetrahedra[i];
    if ((t.corner[1] - t.corner[0])
            .cast<double>()
            .cross((t.corner[2] - t.corner[0]).cast<double>())
            .dot((t.corner[3] - t.corner[0]).cast<double>()) < 0)
      std::swap(t.corner[2], t.corner[3]);
    unsigned in = 0;
    for (unsigned k = 0; k < 4; ++k) in |= static_cast<unsigned>(isIn(at(t.corner[k]), t)) << k;
    const std::array<std::size_t, 4> order = inFirst(in);
    const auto cut = [&](std::size_t a, std::size_t b) {  // on the edge from an inner corner to an outer one
      const Vector3i &p = t.corner[order[a]], &q = t.corner[order[b]];
      pieces[i].corners[pieces[i].count++] = {nameOf(p + q), crossing(at(p), at(q), t)};
    };
    const int count = std::popcount(in);
    if (count == 1) cut(0, 1), cut(0, 2), cut(0, 3);
    if (count == 2) cut(0, 2), cut(0, 3), cut(1, 3), cut(1, 2);
    if (count == 3) cut(0, 3), cut(1, 3), cut(2, 3);
  });
  std::vector<Corner> corners;
  for (const Cut& piece : pieces)
    corners.insert(corners.end(), piece.corners.begin(), piece.corners.begin() + static_cast<std::ptrdiff_t>(piece.count));
  const auto isBefore = [](const Corner& a, const Corner& b) { return a.name < b.name; };
  std::stable_sort(corners.begin(), corners.end(), isBefore);
  corners.erase(std::unique(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) { return a.name == b.name; }),
                corners.end());
  TriangleMesh out;
  for (const Corner& corner : corners) out.positions.push_back(corner.position);
  for (const Cut& piece : pieces) {
    const auto index = [&](std::size_t k) {
      return static_cast<std::uint32_t>(std::lower_bound(corners.begin(), corners.end(), piece.corners[k], isBefore) - corners.begin());
    };
    for (std::size_t k = 2; k < piece.count; ++k) out.triangles.push_back({index(0), index(k - 1), index(k)});
  }
  return out;
}

}  // namespace

TriangleMesh sweptSurface(std::span<const Capsule> capsules, double tolerance, Progress& progress) {
  Sweep sweep(capsules, tolerance);
  const std::vector<Tetrahedron> tetrahedra = sweep.tetrahedra(progress);
  return sweep.surface(tetrahedra);
}

}  // namespace spheretree::builder
