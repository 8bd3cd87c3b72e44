// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/wrap_surface.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

namespace spheretree::builder {
namespace {

/// A callback of CGAL that allows stopping.
struct Stopper {
  const Progress& progress;

  template <class... T>
  void before_facet_treatment(const T&...) {
    progress.check();
  }
  template <class... T>
  void on_alpha_wrapping_begin(const T&...) {}
  template <class... T>
  void on_flood_fill_begin(const T&...) {}
  template <class... T>
  void before_Steiner_point_insertion(const T&...) {}
  template <class... T>
  void after_Steiner_point_insertion(const T&...) {}
  template <class... T>
  void on_flood_fill_end(const T&...) {}
  template <class... T>
  void on_alpha_wrapping_end(const T&...) {}
};

}  // namespace

TriangleMesh wrapSurface(const TriangleMesh& mesh, double alpha, double offset, const Progress& progress) {
  using Point = CGAL::Exact_predicates_inexact_constructions_kernel::Point_3;
  std::vector<Point> points;
  points.reserve(mesh.positions.size());
  for (const Eigen::Vector3d& p : mesh.positions) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<std::array<std::size_t, 3>> faces;
  faces.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) faces.push_back({a, b, c});
  CGAL::Surface_mesh<Point> wrap;
  Stopper stopper{progress};
  CGAL::alpha_wrap_3(points, faces, alpha, offset, wrap, CGAL::parameters::default_values(), CGAL::parameters::visitor(stopper));
  TriangleMesh result;
  std::vector<std::uint32_t> index(wrap.number_of_vertices() + wrap.number_of_removed_vertices());
  for (const auto v : wrap.vertices()) {
    index[v] = static_cast<std::uint32_t>(result.positions.size());
    const Point& p = wrap.point(v);
    result.positions.emplace_back(p.x(), p.y(), p.z());
  }
  for (const auto f : wrap.faces()) {
    Triangle& triangle = result.triangles.emplace_back();
    std::size_t k = 0;
    for (const auto v : wrap.vertices_around_face(wrap.halfedge(f))) triangle[k++] = index[v];
  }
  return result;
}

}  // namespace spheretree::builder
