// SPDX-License-Identifier: GPL-3.0-or-later
// The points at which the triangles of a mesh cut each other, exact and numbered. Every point is constructed from
// corners of the mesh alone, never from another constructed point, so that the length of its numbers is bounded, and
// with it the time of each operation on it. Which points there are is decided by predicates on the corners.
//
// Paper: M. Attene. Indirect predicates for geometric constructions. Computer-Aided Design 126, 2020: a point is named
// by the planes and lines that meet in it. Here the names only avoid constructing a point twice; CGAL constructs it.
// Units: mm. Deterministic.
#pragma once

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "spheretree/core/none.h"
#include "spheretree/core/triangle_mesh.h"

namespace spheretree::builder {

/// What a cut of a triangle lies on: the plane of another triangle, or an edge in the plane of the triangle.
struct CutCarrier {
  std::uint32_t a, b;  // a triangle and kNone, or the two vertices of an edge, the lower one first

  static CutCarrier plane(std::uint32_t triangle) { return {triangle, kNone}; }
  static CutCarrier edge(std::uint32_t u, std::uint32_t v) { return u < v ? CutCarrier{u, v} : CutCarrier{v, u}; }
  bool isPlane() const { return b == kNone; }
};

/// A segment along which a triangle is cut, or a point on it if `from == to`.
struct TriangleCut {
  std::uint32_t from, to;  // points
  CutCarrier carrier;
};

class CutPoints {
 public:
  using Exact = CGAL::Exact_predicates_exact_constructions_kernel;

  /// The vertices of `mesh` are the first points; `mesh` must outlive this object.
  explicit CutPoints(const TriangleMesh& mesh) : mesh_(mesh), exact_(mesh.positions.size()) {}

  /// Cuts two triangles, neither of them flat, along their common points: appends to `first` the cuts of `t` and to
  /// `second` those of `u`.
  void cut(std::uint32_t t, std::uint32_t u, std::vector<TriangleCut>& first, std::vector<TriangleCut>& second);

  /// The point of triangle `t` in which cuts with these carriers cross.
  std::uint32_t crossing(std::uint32_t t, const CutCarrier& a, const CutCarrier& b);

  /// The number of a vertex: that of the first vertex in use at the same place.
  std::uint32_t ofVertex(std::uint32_t v);
  const Exact::Point_3& operator[](std::uint32_t point) const { return *exact_[point]; }

  /// All points, rounded to double; an unused vertex keeps its place.
  std::vector<Eigen::Vector3d> rounded() const;

 private:
  using Name = std::array<std::uint32_t, 5>;  // kind, then what meets in the point
  template <class Construct>
  std::uint32_t named(const Name& name, Construct&& construct);
  std::uint32_t numberOf(Exact::Point_3 p, std::uint32_t proposed);
  Exact::Point_3 exactOf(std::uint32_t v) const;
  std::uint32_t onPlane(const CutCarrier& edge, std::uint32_t t);
  std::uint32_t onEdges(CutCarrier e, CutCarrier f, int axis);
  std::uint32_t onPlanes(std::array<std::uint32_t, 3> t);
  void cutCoplanar(std::uint32_t t, std::uint32_t u, std::vector<TriangleCut>& cuts);

  const TriangleMesh& mesh_;
  std::vector<std::optional<Exact::Point_3>> exact_;  // empty for a vertex that is not in use
  std::map<Exact::Point_3, std::uint32_t> number_;
  std::map<Name, std::uint32_t> by_name_;
};

/// The coordinate axis along which a triangle that is not flat has a projection that is not flat, the one nearest to
/// its normal if rounding allows to tell.
int projectionAxis(const TriangleMesh& mesh, std::uint32_t t);

}  // namespace spheretree::builder
