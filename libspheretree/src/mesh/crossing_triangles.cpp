// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/crossing_triangles.h"

#include <CGAL/Box_intersection_d/Box_with_info_d.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <array>

namespace spheretree::builder {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

Point pointOf(const std::vector<Eigen::Vector3d>& positions, std::uint32_t vertex) {
  const Eigen::Vector3d& p = positions[vertex];
  return {p.x(), p.y(), p.z()};
}

}  // namespace

bool doCross(const std::vector<Eigen::Vector3d>& positions, const Triangle& a, const Triangle& b) {
  std::array<int, 3> shared_a{}, shared_b{};
  int shared = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      if (a[i] == b[j]) shared_a[i] = shared_b[j] = 1, ++shared;
  const auto point = [&](const Triangle& triangle, std::size_t k) { return pointOf(positions, triangle[k % 3]); };
  if (shared == 3) return false;  // a duplicate
  if (shared == 2) {
    // They have further common points only if they are folded flat onto each other.
    const auto i = static_cast<std::size_t>(std::find(shared_a.begin(), shared_a.end(), 0) - shared_a.begin());
    const auto j = static_cast<std::size_t>(std::find(shared_b.begin(), shared_b.end(), 0) - shared_b.begin());
    return CGAL::coplanar(point(a, i + 1), point(a, i + 2), point(a, i), point(b, j)) &&
           CGAL::coplanar_orientation(point(a, i + 1), point(a, i + 2), point(a, i), point(b, j)) == CGAL::POSITIVE;
  }
  const Kernel::Triangle_3 ta(point(a, 0), point(a, 1), point(a, 2)), tb(point(b, 0), point(b, 1), point(b, 2));
  if (shared == 0) return CGAL::do_intersect(ta, tb);
  // If two triangles that share one corner meet elsewhere, the side opposite the corner of one of them meets the other
  // triangle.
  const auto i = static_cast<std::size_t>(std::find(shared_a.begin(), shared_a.end(), 1) - shared_a.begin());
  const auto j = static_cast<std::size_t>(std::find(shared_b.begin(), shared_b.end(), 1) - shared_b.begin());
  return CGAL::do_intersect(ta, Kernel::Segment_3(point(b, j + 1), point(b, j + 2))) ||
         CGAL::do_intersect(tb, Kernel::Segment_3(point(a, i + 1), point(a, i + 2)));
}

bool isFlat(const std::vector<Eigen::Vector3d>& positions, const Triangle& triangle) {
  const auto [a, b, c] = triangle;
  return a == b || b == c || c == a || CGAL::collinear(pointOf(positions, a), pointOf(positions, b), pointOf(positions, c));
}

bool isFlat(const TriangleMesh& mesh, std::size_t triangle) { return isFlat(mesh.positions, mesh.triangles[triangle]); }

CrossingTriangles findCrossingTriangles(const TriangleMesh& mesh, std::size_t max_pairs, const Progress& progress) {
  using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, std::uint32_t>;
  std::vector<Box> boxes;
  boxes.reserve(mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (t % 1024 == 0) progress.check();
    if (isFlat(mesh, t)) continue;
    const auto [a, b, c] = mesh.triangles[t];
    boxes.emplace_back(pointOf(mesh.positions, a).bbox() + pointOf(mesh.positions, b).bbox() + pointOf(mesh.positions, c).bbox(), t);
  }
  struct Enough {};
  CrossingTriangles found;
  try {
    CGAL::box_self_intersection_d(boxes.begin(), boxes.end(), [&](const Box& a, const Box& b) {
      progress.check();
      if (!doCross(mesh.positions, mesh.triangles[a.info()], mesh.triangles[b.info()])) return;
      if (found.pairs.size() == max_pairs) throw Enough{};
      found.pairs.push_back(std::minmax(a.info(), b.info()));
    });
  } catch (const Enough&) {
    found.is_stopped = true;
  }
  std::sort(found.pairs.begin(), found.pairs.end());
  return found;
}

}  // namespace spheretree::builder
