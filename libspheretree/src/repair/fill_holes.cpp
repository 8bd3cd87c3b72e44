// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/fill_holes.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/refine.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/utility.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <functional>
#include <map>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr int kMaxCubicLoop = 400;  // vertices of a degenerate loop that is spanned in O(n^3), 10^7 steps

/// Asks for an interrupt and spends work in CGAL's loops.
struct SpanVisitor : CGAL::Polygon_mesh_processing::Hole_filling::Default_visitor {
  struct NoSpan {};
  RepairWork& work;

  explicit SpanVisitor(RepairWork& w) : work(w) {}
  void quadratic_step() const { work.spend(1); }
  void start_cubic_phase(int n) const {
    if (n > kMaxCubicLoop) throw NoSpan{};
  }
  void cubic_step() const { work.spend(1); }
};

}  // namespace

/// In the boundary of triangles as many edges enter a vertex as leave it, so that a walk ends where it began; where it
/// visits a vertex twice, a loop is cut off.
std::vector<std::vector<std::uint32_t>> findHoleLoops(const TriangleMesh& mesh) {
  std::map<std::uint32_t, std::vector<std::uint32_t>> next;  // taken from the end
  for (const OpenEdge& e : findOpenEdges(mesh))
    for (int i = 0; i < e.times; ++i) next[e.to].push_back(e.from);
  std::vector<std::vector<std::uint32_t>> loops;
  std::map<std::uint32_t, std::size_t> place;  // index on the path
  for (auto& [start, unused] : next) {
    while (!next[start].empty()) {
      std::vector<std::uint32_t> path{start};
      place.clear();
      place[start] = 0;
      while (!path.empty()) {
        std::vector<std::uint32_t>& ways = next[path.back()];
        if (ways.empty()) break;  // back at the start
        const std::uint32_t v = ways.back();
        ways.pop_back();
        const auto at = place.find(v);
        if (at == place.end()) {
          place[v] = path.size();
          path.push_back(v);
          continue;
        }
        const auto from = path.begin() + static_cast<std::ptrdiff_t>(at->second);
        loops.emplace_back(from, path.end());
        for (auto i = from + 1; i != path.end(); ++i) place.erase(*i);
        path.erase(from + 1, path.end());
      }
    }
  }
  return loops;
}

std::vector<Triangle> spanLoop(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop, const Progress& progress) {
  RepairWork work(progress);
  return spanLoop(mesh, loop, work);
}

std::vector<Triangle> spanLoop(const TriangleMesh& mesh, const std::vector<std::uint32_t>& loop, RepairWork& work) {
  std::vector<Triangle> result;
  if (loop.size() == 3) return {{loop[0], loop[1], loop[2]}};
  std::vector<Kernel::Point_3> points;
  for (const std::uint32_t v : loop) points.emplace_back(mesh.positions[v].x(), mesh.positions[v].y(), mesh.positions[v].z());
  std::vector<CGAL::Triple<int, int, int>> faces;
  try {
    SpanVisitor visitor(work);
    CGAL::Polygon_mesh_processing::triangulate_hole_polyline(
        points, std::back_inserter(faces),
        CGAL::parameters::use_delaunay_triangulation(true).geom_traits(Kernel()).visitor(std::ref(visitor)));
  } catch (const SpanVisitor::NoSpan&) {
    return {};
  } catch (
      const CGAL::Failure_exception&) {  // if CGAL's assertions are enabled: a loop that is not a polygon, such as one of coincident points
    return {};
  }
  for (const auto& face : faces) {
    std::array<int, 3> i{face.first, face.second, face.third};
    std::sort(i.begin(), i.end());  // in the direction of the loop
    result.push_back({loop[static_cast<std::size_t>(i[0])], loop[static_cast<std::size_t>(i[1])], loop[static_cast<std::size_t>(i[2])]});
  }
  return result;
}

void refineSpan(TriangleMesh& mesh, std::vector<Triangle>& span, double density) {
  using Surface = CGAL::Surface_mesh<Kernel::Point_3>;
  Surface surface;
  std::map<std::uint32_t, Surface::Vertex_index> own;
  std::vector<std::uint32_t> vertex;  // for each vertex of the surface: vertex of the mesh
  for (const Triangle& t : span) {
    std::array<Surface::Vertex_index, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [entry, is_new] = own.try_emplace(t[k]);
      if (is_new) {
        const Eigen::Vector3d& p = mesh.positions[t[k]];
        entry->second = surface.add_vertex({p.x(), p.y(), p.z()});
        vertex.push_back(t[k]);
      }
      corners[k] = entry->second;
    }
    if (surface.add_face(corners[0], corners[1], corners[2]) == Surface::null_face()) return;
  }
  const std::vector<Surface::Face_index> faces(surface.faces().begin(), surface.faces().end());
  CGAL::Polygon_mesh_processing::refine(surface, faces, CGAL::Emptyset_iterator(), CGAL::Emptyset_iterator(),
                                        CGAL::parameters::density_control_factor(density));
  for (std::size_t v = vertex.size(); v < surface.number_of_vertices(); ++v) {
    const Kernel::Point_3& p = surface.point(Surface::Vertex_index(static_cast<std::uint32_t>(v)));
    vertex.push_back(static_cast<std::uint32_t>(mesh.positions.size()));
    mesh.positions.emplace_back(p.x(), p.y(), p.z());
  }
  span.clear();
  for (const Surface::Face_index f : surface.faces()) {
    Triangle t;
    std::size_t k = 0;
    for (const Surface::Vertex_index v : CGAL::vertices_around_face(surface.halfedge(f), surface)) t[k++] = vertex[v];
    span.push_back(t);
  }
}

std::vector<FilledHole> fillHoles(RepairSoup& soup, RepairWork& work, std::size_t max_edges) {
  TriangleMesh& mesh = soup.mesh;
  std::vector<FilledHole> holes;
  for (const std::vector<std::uint32_t>& loop : findHoleLoops(mesh)) {
    work.spend(loop.size());
    FilledHole hole;
    hole.edges = loop.size();
    Eigen::AlignedBox3d box;
    Vector3d middle = Vector3d::Zero();
    for (std::size_t i = 0; i < loop.size(); ++i) {
      const Vector3d &a = mesh.positions[loop[i]], &b = mesh.positions[loop[(i + 1) % loop.size()]];
      box.extend(a);
      hole.length += (b - a).norm();
      middle += a / static_cast<double>(loop.size());
    }
    hole.across = box.diagonal().norm();
    std::vector<Triangle> filling;
    if (loop.size() <= max_edges) filling = spanLoop(mesh, loop, work);
    if (filling.empty()) {
      const auto hub = static_cast<std::uint32_t>(mesh.positions.size());
      mesh.positions.push_back(middle);
      for (std::size_t i = 0; i < loop.size(); ++i) filling.push_back({loop[i], loop[(i + 1) % loop.size()], hub});
    }
    for (const Triangle& triangle : filling) {
      hole.triangles.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
      mesh.triangles.push_back(triangle);
      soup.source.push_back(kNone);
    }
    holes.push_back(std::move(hole));
  }
  std::stable_sort(holes.begin(), holes.end(), [](const FilledHole& a, const FilledHole& b) { return a.length > b.length; });
  return holes;
}

}  // namespace spheretree::builder
