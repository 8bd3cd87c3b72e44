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

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Loop = std::vector<std::uint32_t>;

constexpr std::size_t kMostSpanned = 3000;  // vertices of a loop that is spanned at once
constexpr int kMostWidened = 4;             // rounds of widening holes whose filling crosses something
constexpr int kMostSmoothing = 2000;        // rounds until the outline of the base does not cross itself

double lengthOf(const TriangleMesh& mesh, const Loop& loop) {
  double length = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) length += (mesh.positions[loop[(i + 1) % loop.size()]] - mesh.positions[loop[i]]).norm();
  return length;
}

void addTriangles(ScanSurface& s, const std::vector<Triangle>& triangles) {
  for (const Triangle& t : triangles) {
    s.mesh.triangles.push_back(t);
    s.is_invented.push_back(1);
    if (!s.region.empty()) s.region.push_back(kGumRegion);
  }
}

/// A simple polygon as triangles that run as it does, indices from 0.
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

/// The shadow of the border along `up`, as points of the plane, smoothed until it is a simple polygon.
std::vector<Kernel::Point_2> outlineOf(const TriangleMesh& mesh, const Loop& loop, const Vector3d& u, const Vector3d& v) {
  std::vector<Kernel::Point_2> points;
  for (const std::uint32_t i : loop) points.emplace_back(mesh.positions[i].dot(u), mesh.positions[i].dot(v));
  const std::size_t n = points.size();
  for (int round = 0; round < kMostSmoothing && !CGAL::is_simple_2(points.begin(), points.end()); ++round) {
    std::vector<Kernel::Point_2> next;
    for (std::size_t i = 0; i < n; ++i) {
      const Kernel::Point_2 &a = points[(i + n - 1) % n], &b = points[i], &c = points[(i + 1) % n];
      next.emplace_back((a.x() + 2 * b.x() + c.x()) / 4, (a.y() + 2 * b.y() + c.y()) / 4);
    }
    points = std::move(next);
  }
  return points;
}

/// Every border loop but the outer one of the largest component.
std::size_t fillLoops(ScanSurface& s) {
  TriangleMesh& mesh = s.mesh;
  Groups groups(mesh.positions.size());
  for (const Triangle& t : mesh.triangles) groups.join(t[0], t[1]), groups.join(t[1], t[2]);
  std::map<std::uint32_t, double> area;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) area[groups.root(mesh.triangles[t][0])] += triangleArea(mesh, t);
  const std::uint32_t largest =
      std::max_element(area.begin(), area.end(), [](const auto& a, const auto& b) { return a.second < b.second; })->first;
  const std::vector<Loop> loops = findHoleLoops(mesh);
  std::size_t outer = loops.size();
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (groups.root(loops[i][0]) == largest && (outer == loops.size() || lengthOf(mesh, loops[i]) > lengthOf(mesh, loops[outer])))
      outer = i;
  std::size_t filled = 0;
  for (std::size_t i = 0; i < loops.size(); ++i) {
    if (i == outer) continue;
    ++filled;
    std::vector<Triangle> filling;
    if (loops[i].size() <= kMostSpanned) filling = spanLoop(mesh, loops[i]);
    if (filling.empty()) {  // from its middle
      const auto hub = static_cast<std::uint32_t>(mesh.positions.size());
      Vector3d middle = Vector3d::Zero();
      for (const std::uint32_t v : loops[i]) middle += mesh.positions[v] / static_cast<double>(loops[i].size());
      mesh.positions.push_back(middle);
      s.vertex_region.push_back(s.vertex_region[loops[i][0]]);
      for (std::size_t k = 0; k < loops[i].size(); ++k) filling.push_back({loops[i][k], loops[i][(k + 1) % loops[i].size()], hub});
    }
    addTriangles(s, filling);
  }
  return filled;
}

/// Triangles of the scan that cross a filling, and `with_ring` those round the corners of fillings that cross anything;
/// empty if nothing crosses. Looks at what is within three rings of the fillings, which come from `scanned` on.
std::vector<char> crossedByFillings(const TriangleMesh& mesh, std::size_t scanned, bool with_ring) {
  std::vector<char> is_near(mesh.positions.size(), 0);
  for (std::size_t t = scanned; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) is_near[v] = 1;
  const auto isNear = [&](const Triangle& t) { return is_near[t[0]] || is_near[t[1]] || is_near[t[2]]; };
  for (int ring = 0; ring < 3; ++ring) {
    std::vector<std::uint32_t> more;
    for (const Triangle& t : mesh.triangles)
      if (isNear(t)) more.insert(more.end(), t.begin(), t.end());
    for (const std::uint32_t v : more) is_near[v] = 1;
  }
  TriangleMesh near{mesh.positions, {}, {}, {}};
  std::vector<std::uint32_t> index;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (isNear(mesh.triangles[t])) near.triangles.push_back(mesh.triangles[t]), index.push_back(t);
  std::vector<char> is_bad(mesh.positions.size(), 0), is_dropped(scanned, 0);
  bool is_any = false;
  for (const auto& [a, b] : findCrossingTriangles(near, kMostSplitCrossings).pairs) {
    if (index[a] < scanned && index[b] < scanned) continue;  // the scan crosses itself
    is_any = true;
    for (const std::uint32_t t : {index[a], index[b]}) {
      if (t < scanned) is_dropped[t] = 1;
      if (t >= scanned && (with_ring || (index[a] >= scanned && index[b] >= scanned)))
        for (const std::uint32_t v : mesh.triangles[t]) is_bad[v] = 1;
    }
  }
  if (!is_any) return {};
  for (std::size_t t = 0; t < scanned; ++t)
    for (const std::uint32_t v : mesh.triangles[t]) is_dropped[t] |= is_bad[v];
  return is_dropped;
}

/// Leaves out what is true in `is_dropped`, and makes the rest manifold. Before anything was invented.
void dropTriangles(ScanSurface& s, const std::vector<char>& is_dropped) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < is_dropped.size(); ++t)
    if (!is_dropped[t]) s.mesh.triangles[kept++] = s.mesh.triangles[t];
  s.mesh.triangles.resize(kept);
  makeManifold(s.mesh);
  s.is_invented.assign(s.mesh.triangles.size(), 0);
}

}  // namespace

std::size_t dropCrossings(ScanSurface& s) {
  std::vector<char> is_dropped(s.mesh.triangles.size(), 0);
  std::size_t dropped = 0;
  for (const auto& [a, b] : findCrossingTriangles(s.mesh, kMostSplitCrossings).pairs)
    for (const std::uint32_t t : {a, b}) dropped += !is_dropped[t], is_dropped[t] = 1;
  if (dropped > 0) dropTriangles(s, is_dropped);
  return dropped;
}

std::size_t fillScanHoles(ScanSurface& s) {
  for (int round = 0;; ++round) {
    const std::size_t scanned = s.mesh.triangles.size(), points = s.mesh.positions.size(), filled = fillLoops(s);
    if (round == kMostWidened) return filled;
    const std::vector<char> is_dropped = crossedByFillings(s.mesh, scanned, round > 0);
    if (is_dropped.empty()) return filled;
    s.mesh.positions.resize(points);
    s.vertex_region.resize(points);
    s.mesh.triangles.resize(scanned);
    dropTriangles(s, is_dropped);
  }
}

void addBase(ScanSurface& s, const Vector3d& up, double depth) {
  const std::vector<Loop> loops = findHoleLoops(s.mesh);
  double lowest = 1e300;
  for (const Triangle& t : s.mesh.triangles)
    for (const std::uint32_t v : t) lowest = std::min(lowest, s.mesh.positions[v].dot(up));
  int least = 0;
  up.cwiseAbs().minCoeff(&least);
  const Vector3d u = up.cross(Vector3d::Unit(least)).normalized(), v = up.cross(u);
  for (const Loop& loop : loops) {
    const std::vector<Kernel::Point_2> outline = outlineOf(s.mesh, loop, u, v);
    const auto n = static_cast<std::uint32_t>(loop.size()), first = static_cast<std::uint32_t>(s.mesh.positions.size());
    for (const Kernel::Point_2& p : outline) s.mesh.positions.push_back(p.x() * u + p.y() * v + (lowest - depth) * up);
    std::vector<Triangle> wall;
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t j = (i + 1) % n;
      wall.push_back({loop[i], loop[j], first + j});
      wall.push_back({loop[i], first + j, first + i});
    }
    std::vector<Triangle> base;
    if (CGAL::is_simple_2(outline.begin(), outline.end())) {
      base = triangulated(outline);
      for (Triangle& t : base)
        for (std::uint32_t& corner : t) corner += first;
    } else {  // closed all the same; the repair of the gum decides what is inside
      const auto hub = static_cast<std::uint32_t>(s.mesh.positions.size());
      Vector3d middle = Vector3d::Zero();
      for (std::uint32_t i = 0; i < n; ++i) middle += s.mesh.positions[first + i] / n;
      s.mesh.positions.push_back(middle);
      for (std::uint32_t i = 0; i < n; ++i) base.push_back({first + i, first + (i + 1) % n, hub});
    }
    addTriangles(s, wall);
    addTriangles(s, base);
  }
}

}  // namespace spheretree::builder
