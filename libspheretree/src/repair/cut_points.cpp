// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/cut_points.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Exact = CutPoints::Exact;
using Filtered = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr double kTight = 4 * std::numeric_limits<double>::epsilon();  // relative width of an interval that is rounded as it is

enum Kind : std::uint32_t { kEdgeAndPlane, kTwoEdges, kThreePlanes };

Filtered::Point_3 pointOf(const TriangleMesh& mesh, std::uint32_t v) {
  const Vector3d& p = mesh.positions[v];
  return {p.x(), p.y(), p.z()};
}

/// Side of the plane of triangle `t` on which a vertex lies: -1, 0, 1; exact.
int sideOf(const TriangleMesh& mesh, std::uint32_t t, std::uint32_t v) {
  const Triangle& c = mesh.triangles[t];
  if (v == c[0] || v == c[1] || v == c[2]) return 0;
  return CGAL::orientation(pointOf(mesh, c[0]), pointOf(mesh, c[1]), pointOf(mesh, c[2]), pointOf(mesh, v));
}

/// Vertices as seen along an axis.
struct View {
  const TriangleMesh& mesh;
  int axis;

  Filtered::Point_2 operator()(std::uint32_t v) const {
    const Vector3d& p = mesh.positions[v];
    return {p[(axis + 1) % 3], p[(axis + 2) % 3]};
  }
  int turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const { return CGAL::orientation((*this)(a), (*this)(b), (*this)(c)); }
  /// Whether a vertex in the plane of a triangle lies in it, with its border.
  bool contains(const Triangle& t, std::uint32_t v) const {
    const int whole = turn(t[0], t[1], t[2]);
    for (std::size_t k = 0; k < 3; ++k)
      if (turn(t[k], t[(k + 1) % 3], v) * whole < 0) return false;
    return true;
  }
  /// Whether a vertex lies on an edge, with its ends.
  bool isOn(std::uint32_t a, std::uint32_t b, std::uint32_t v) const {
    return turn(a, b, v) == 0 && CGAL::are_ordered_along_line((*this)(a), (*this)(v), (*this)(b));
  }
  /// Whether two edges cross within both.
  bool doCross(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const {
    return turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0;
  }
};

/// Whether the line through two vertices on different sides of a triangle's plane meets the triangle, with its border.
bool lineMeets(const TriangleMesh& mesh, std::uint32_t p, std::uint32_t q, const Triangle& t) {
  bool is_left = false, is_right = false;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = t[k], b = t[(k + 1) % 3];
    if (p == a || p == b || q == a || q == b) continue;  // the line meets this side
    const int side = CGAL::orientation(pointOf(mesh, p), pointOf(mesh, q), pointOf(mesh, a), pointOf(mesh, b));
    is_left |= side > 0, is_right |= side < 0;
  }
  return !(is_left && is_right);
}

/// The ends of a cut, without repetition.
struct Ends {
  std::array<std::uint32_t, 2> point{};
  std::size_t count = 0;
  void add(std::uint32_t p) {
    if (count < 2 && (count == 0 || point[0] != p)) point[count++] = p;
  }
  TriangleCut cutAlong(const CutCarrier& carrier) const { return {point[0], point[count - 1], carrier}; }
};

double rounded(const Exact::FT& x) {
  auto [low, high] = CGAL::to_interval(x);
  if (!(high - low <= kTight * std::max(std::abs(low), std::abs(high)))) {
    x.exact();  // now the interval is as narrow as doubles allow
    std::tie(low, high) = CGAL::to_interval(x);
  }
  return low + (high - low) / 2;
}

}  // namespace

int projectionAxis(const TriangleMesh& mesh, std::uint32_t t) {
  const Vector3d normal = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).cwiseAbs();
  int best = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (normal[axis] > normal[best]) best = axis;
  const auto [a, b, c] = mesh.triangles[t];
  for (int i = 0; i < 3; ++i) {  // rounding may have chosen an axis along which the triangle is flat
    const int axis = (best + i) % 3;
    if (View{mesh, axis}.turn(a, b, c) != 0) return axis;
  }
  return best;
}

Exact::Point_3 CutPoints::exactOf(std::uint32_t v) const {
  const Vector3d& p = mesh_.positions[v];
  return {p.x(), p.y(), p.z()};
}

std::uint32_t CutPoints::numberOf(Exact::Point_3 p, std::uint32_t proposed) {
  const auto [at, is_new] = number_.try_emplace(p, proposed);
  if (is_new) {
    if (proposed == exact_.size()) exact_.emplace_back();
    exact_[proposed] = std::move(p);
  }
  return at->second;
}

std::uint32_t CutPoints::ofVertex(std::uint32_t v) {
  if (exact_[v]) return v;
  return numberOf(exactOf(v), v);
}

template <class Construct>
std::uint32_t CutPoints::named(const Name& name, Construct&& construct) {
  const auto [at, is_new] = by_name_.try_emplace(name, 0);
  if (!is_new) return at->second;
  return at->second = numberOf(construct(), static_cast<std::uint32_t>(exact_.size()));
}

std::uint32_t CutPoints::onPlane(const CutCarrier& edge, std::uint32_t t) {
  return named({kEdgeAndPlane, edge.a, edge.b, t, 0}, [&] {
    const auto [a, b, c] = mesh_.triangles[t];
    return Exact().construct_plane_line_intersection_point_3_object()(exactOf(a), exactOf(b), exactOf(c), exactOf(edge.a), exactOf(edge.b));
  });
}

std::uint32_t CutPoints::onEdges(CutCarrier e, CutCarrier f, int axis) {
  if (std::tie(f.a, f.b) < std::tie(e.a, e.b)) std::swap(e, f);
  return named({kTwoEdges, e.a, e.b, f.a, f.b}, [&] {
    std::array<int, 3> along{};  // the plane through `f` and the axis
    along[static_cast<std::size_t>(axis)] = 1;
    const Exact::Point_3 p = exactOf(f.a);
    return Exact().construct_plane_line_intersection_point_3_object()(p, exactOf(f.b), p + Exact::Vector_3(along[0], along[1], along[2]),
                                                                      exactOf(e.a), exactOf(e.b));
  });
}

std::uint32_t CutPoints::onPlanes(std::array<std::uint32_t, 3> t) {
  std::sort(t.begin(), t.end());
  return named({kThreePlanes, t[0], t[1], t[2], 0}, [&] {
    const Exact::Point_3 origin = exactOf(mesh_.triangles[t[0]][0]);
    std::array<Exact::Vector_3, 3> normal;
    std::array<Exact::FT, 3> height;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b, c] = mesh_.triangles[t[i]];
      const Exact::Point_3 p = exactOf(a);
      normal[i] = CGAL::cross_product(exactOf(b) - p, exactOf(c) - p);
      height[i] = normal[i] * (p - origin);
    }
    Exact::Vector_3 sum(0, 0, 0);
    for (std::size_t i = 0; i < 3; ++i) sum = sum + height[i] * CGAL::cross_product(normal[(i + 1) % 3], normal[(i + 2) % 3]);
    return origin + sum / (normal[0] * CGAL::cross_product(normal[1], normal[2]));
  });
}

std::uint32_t CutPoints::crossing(std::uint32_t t, const CutCarrier& a, const CutCarrier& b) {
  if (a.isPlane() && b.isPlane()) return onPlanes({t, a.a, b.a});
  if (a.isPlane()) return onPlane(b, a.a);
  if (b.isPlane()) return onPlane(a, b.a);
  return onEdges(a, b, projectionAxis(mesh_, t));
}

/// The sides of `u` where they lie in `t`, in the plane of both.
void CutPoints::cutCoplanar(std::uint32_t t, std::uint32_t u, std::vector<TriangleCut>& cuts) {
  const View view{mesh_, projectionAxis(mesh_, t)};
  const Triangle &own = mesh_.triangles[t], &other = mesh_.triangles[u];
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t a = other[k], b = other[(k + 1) % 3];
    Ends ends;
    for (const std::uint32_t v : {a, b})
      if (view.contains(own, v)) ends.add(ofVertex(v));
    for (std::size_t j = 0; j < 3; ++j) {
      const std::uint32_t c = own[j], d = own[(j + 1) % 3];
      if (view.isOn(a, b, c)) ends.add(ofVertex(c));
      if (view.doCross(a, b, c, d)) ends.add(onEdges(CutCarrier::edge(a, b), CutCarrier::edge(c, d), view.axis));
    }
    if (ends.count > 0) cuts.push_back(ends.cutAlong(CutCarrier::edge(a, b)));
  }
}

void CutPoints::cut(std::uint32_t t, std::uint32_t u, std::vector<TriangleCut>& first, std::vector<TriangleCut>& second) {
  Ends ends;
  for (const auto& [own, other] : {std::pair{t, u}, std::pair{u, t}}) {
    const Triangle &c = mesh_.triangles[own], &plane = mesh_.triangles[other];
    std::array<int, 3> side{};
    for (std::size_t k = 0; k < 3; ++k) side[k] = sideOf(mesh_, other, c[k]);
    if (side[0] == 0 && side[1] == 0 && side[2] == 0) {
      cutCoplanar(t, u, first);
      cutCoplanar(u, t, second);
      return;
    }
    const View view{mesh_, projectionAxis(mesh_, other)};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      if (side[k] == 0 && view.contains(plane, c[k])) ends.add(ofVertex(c[k]));
      if (side[k] * side[next] < 0 && lineMeets(mesh_, c[k], c[next], plane)) ends.add(onPlane(CutCarrier::edge(c[k], c[next]), other));
    }
  }
  if (ends.count == 0) return;
  first.push_back(ends.cutAlong(CutCarrier::plane(u)));
  second.push_back(ends.cutAlong(CutCarrier::plane(t)));
}

std::vector<Vector3d> CutPoints::rounded() const {
  std::vector<Vector3d> positions = mesh_.positions;
  positions.reserve(exact_.size());
  for (std::size_t i = positions.size(); i < exact_.size(); ++i)
    positions.emplace_back(builder::rounded(exact_[i]->x()), builder::rounded(exact_[i]->y()), builder::rounded(exact_[i]->z()));
  return positions;
}

}  // namespace spheretree::builder
