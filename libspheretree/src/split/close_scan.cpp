// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/close_scan.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_2_algorithms.h>
#include <CGAL/Triangulation_face_base_with_info_2.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>

#include "mesh/crossing_triangles.h"
#include "mesh/mesh_edges.h"
#include "repair/fill_holes.h"
#include "spheretree/builder/mesh_checks.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Loop = std::vector<std::uint32_t>;

constexpr int kBaseRings = 10;       // rings of triangles at the scan's border that are tested against the base
constexpr int kMaxTrims = 10;        // rounds of trimming the border
constexpr int kMaxSmoothing = 2000;  // rounds of smoothing until the outline of the base does not cross itself

void addTriangles(ScanSurface& s, const std::vector<Triangle>& triangles) {
  for (const Triangle& t : triangles) {
    s.mesh.triangles.push_back(t);
    s.is_invented.push_back(1);
    if (!s.region.empty()) s.region.push_back(kGumRegion);
  }
}

/// Triangulates a simple polygon, with its winding; indices from 0.
std::vector<Triangle> triangulated(const std::vector<Kernel::Point_2>& polygon) {
  using Vertex = CGAL::Triangulation_vertex_base_with_info_2<std::uint32_t, Kernel>;
  using Face = CGAL::Constrained_triangulation_face_base_2<Kernel, CGAL::Triangulation_face_base_with_info_2<int, Kernel>>;
  using Cdt = CGAL::Constrained_Delaunay_triangulation_2<Kernel, CGAL::Triangulation_data_structure_2<Vertex, Face>>;
  Cdt cdt;
  std::vector<Cdt::Vertex_handle> handles;
  for (std::uint32_t i = 0; i < polygon.size(); ++i) {
    handles.push_back(cdt.insert(polygon[i]));
    handles.back()->info() = i;
  }
  for (std::size_t i = 0; i < handles.size(); ++i) cdt.insert_constraint(handles[i], handles[(i + 1) % handles.size()]);
  for (auto f = cdt.all_faces_begin(); f != cdt.all_faces_end(); ++f) f->info() = -1;
  std::vector<Cdt::Face_handle> stack{cdt.infinite_face()};  // 0: outside, 1: inside
  std::vector<Cdt::Face_handle> behind;
  for (int side = 0; !stack.empty(); ++side) {
    while (!stack.empty()) {
      const Cdt::Face_handle f = stack.back();
      stack.pop_back();
      if (f->info() >= 0) continue;
      f->info() = side % 2;
      for (int k = 0; k < 3; ++k)
        if (f->neighbor(k)->info() < 0) (f->is_constrained(k) ? behind : stack).push_back(f->neighbor(k));
    }
    stack.swap(behind);
  }
  const bool is_left = CGAL::orientation_2(polygon.begin(), polygon.end()) == CGAL::COUNTERCLOCKWISE;
  std::vector<Triangle> triangles;
  for (auto f = cdt.finite_faces_begin(); f != cdt.finite_faces_end(); ++f) {
    if (f->info() != 1) continue;
    Triangle t{f->vertex(0)->info(), f->vertex(1)->info(), f->vertex(2)->info()};
    if (!is_left) std::swap(t[1], t[2]);
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    triangles.push_back(t);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// The border projected along `up`, as points of the plane, smoothed until it is a simple polygon.
std::vector<Kernel::Point_2> outlineOf(const TriangleMesh& mesh, const Loop& loop, const Vector3d& u, const Vector3d& v) {
  std::vector<Kernel::Point_2> points;
  for (const std::uint32_t i : loop) points.emplace_back(mesh.positions[i].dot(u), mesh.positions[i].dot(v));
  const std::size_t n = points.size();
  for (int round = 0; round < kMaxSmoothing && !CGAL::is_simple_2(points.begin(), points.end()); ++round) {
    std::vector<Kernel::Point_2> next;
    for (std::size_t i = 0; i < n; ++i) {
      const Kernel::Point_2 &a = points[(i + n - 1) % n], &b = points[i], &c = points[(i + 1) % n];
      next.emplace_back((a.x() + 2 * b.x() + c.x()) / 4, (a.y() + 2 * b.y() + c.y()) / 4);
    }
    points = std::move(next);
  }
  return points;
}

struct Base {
  std::vector<Vector3d> points;     // appended to those of the mesh
  std::vector<Triangle> triangles;  // the wall, then the floor
};

Base baseUnder(const TriangleMesh& mesh, const Loop& loop, const Vector3d& up, double depth) {
  double lowest = 1e300;
  for (const Triangle& t : mesh.triangles)
    for (const std::uint32_t v : t) lowest = std::min(lowest, mesh.positions[v].dot(up));
  int smallest = 0;
  up.cwiseAbs().minCoeff(&smallest);
  const Vector3d u = up.cross(Vector3d::Unit(smallest)).normalized(), v = up.cross(u);
  const std::vector<Kernel::Point_2> outline = outlineOf(mesh, loop, u, v);
  const auto n = static_cast<std::uint32_t>(loop.size()), first = static_cast<std::uint32_t>(mesh.positions.size());
  Base base;
  for (const Kernel::Point_2& p : outline) base.points.push_back(p.x() * u + p.y() * v + (lowest - depth) * up);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    base.triangles.push_back({loop[i], loop[j], first + j});
    base.triangles.push_back({loop[i], first + j, first + i});
  }
  if (CGAL::is_simple_2(outline.begin(), outline.end())) {
    for (const Triangle& t : triangulated(outline)) base.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  } else {  // the outline still crosses itself; the repair of the gum decides what is inside
    Vector3d middle = Vector3d::Zero();
    for (const Vector3d& p : base.points) middle += p / n;
    base.points.push_back(middle);
    for (std::uint32_t i = 0; i < n; ++i) base.triangles.push_back({first + i, first + (i + 1) % n, first + n});
  }
  return base;
}

/// Triangles of the mesh that a base crosses, and triangles at the corners of a base that crosses itself; empty if
/// there are none. Tests only the rings near the loop.
std::vector<char> crossedByBase(const TriangleMesh& mesh, const Loop& loop, const Base& base) {
  const std::vector<std::uint32_t> index = trianglesNear(mesh, loop, kBaseRings);
  TriangleMesh both{mesh.positions, {}, {}, {}};
  both.positions.insert(both.positions.end(), base.points.begin(), base.points.end());
  for (const std::uint32_t t : index) both.triangles.push_back(mesh.triangles[t]);
  both.triangles.insert(both.triangles.end(), base.triangles.begin(), base.triangles.end());
  std::vector<char> is_dropped(mesh.triangles.size(), 0), is_bad(mesh.positions.size(), 0);
  bool is_any = false;
  for (const auto& [a, b] : findCrossingTriangles(both, kMaxCrossingPairs).pairs) {
    if (b < index.size()) continue;  // a pair within the mesh
    is_any = true;
    if (a < index.size()) {
      is_dropped[index[a]] = 1;
      continue;
    }
    for (const std::uint32_t t : {a, b})
      for (const std::uint32_t v : both.triangles[t])
        if (v < is_bad.size()) is_bad[v] = 1;
  }
  if (!is_any) return {};
  for (std::size_t t = 0; t < is_dropped.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) is_dropped[t] |= is_bad[v];
  return is_dropped;
}

}  // namespace

std::vector<std::uint32_t> findOuterLoop(const TriangleMesh& mesh) {
  Groups groups(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) groups.join(t[0], t[1]), groups.join(t[1], t[2]);
  std::map<std::uint32_t, double> area;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area[groups.root(mesh.triangles[t][0])] += triangleArea(mesh, t);
  if (area.empty()) return {};
  const std::uint32_t largest =
      std::max_element(area.begin(), area.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
  Loop outer;
  double longest = -1;
  for (const Loop& loop : findHoleLoops(mesh)) {
    double length = 0;
    for (std::size_t i = 0; i < loop.size(); ++i) length += (mesh.positions[loop[(i + 1) % loop.size()]] - mesh.positions[loop[i]]).norm();
    if (groups.root(loop[0]) == largest && length > longest) longest = length, outer = loop;
  }
  return outer;
}

void clearBase(ScanSurface& s, const Vector3d& up, double depth) {
  for (int round = 0; round < kMaxTrims; ++round) {
    const Loop loop = findOuterLoop(s.mesh);
    if (loop.empty()) return;
    const std::vector<char> is_dropped = crossedByBase(s.mesh, loop, baseUnder(s.mesh, loop, up, depth));
    if (is_dropped.empty()) return;
    dropTriangles(s, is_dropped);
  }
}

void addBase(ScanSurface& s, const Vector3d& up, double depth) {
  for (const Loop& loop : findHoleLoops(s.mesh)) {
    const Base base = baseUnder(s.mesh, loop, up, depth);
    s.mesh.positions.insert(s.mesh.positions.end(), base.points.begin(), base.points.end());
    addTriangles(s, base.triangles);
  }
}

}  // namespace spheretree::builder
