// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh_nesting.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>
#include <map>

#include "geometry/box_tree.h"

namespace spheretree::builder {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

/// +1 if the ray from `p` along +z leaves through the front of triangle `t`, -1 through its back, 0 if it misses the
/// triangle. Exact, and consistent where the ray meets edges or corners: as if `p` were moved by an infinitesimal step
/// along +x and +y.
int crossingAbove(const TriangleMesh& mesh, std::uint32_t t, const Eigen::Vector3d& at) {
  const auto point = [](const Eigen::Vector3d& q) { return Kernel::Point_3(q.x(), q.y(), q.z()); };
  const Kernel::Point_3 p = point(at);
  int turns = 0;  // winding number of the projected triangle around the projection of p
  const auto flat = [](const Kernel::Point_3& q) { return Kernel::Point_2(q.x(), q.y()); };
  for (std::size_t k = 0; k < 3; ++k) {
    const Kernel::Point_3 a = point(mesh.positions[mesh.triangles[t][k]]), b = point(mesh.positions[mesh.triangles[t][(k + 1) % 3]]);
    const bool up = a.y() <= p.y() && p.y() < b.y(), down = b.y() <= p.y() && p.y() < a.y();
    if (!up && !down) continue;
    const CGAL::Orientation side = CGAL::orientation(flat(a), flat(b), flat(p));
    if (up && side == CGAL::LEFT_TURN) ++turns;
    if (down && side == CGAL::RIGHT_TURN) --turns;
  }
  if (turns == 0) return 0;
  // A positive turn means that the front faces up; then p is below the triangle if it is behind it.
  const Triangle& corners = mesh.triangles[t];
  const CGAL::Orientation place =
      CGAL::orientation(point(mesh.positions[corners[0]]), point(mesh.positions[corners[1]]), point(mesh.positions[corners[2]]), p);
  const bool is_below = turns > 0 ? place == CGAL::NEGATIVE : place == CGAL::POSITIVE;
  return is_below ? turns : 0;
}

}  // namespace

std::vector<std::vector<Enclosure>> findEnclosures(const TriangleMesh& mesh, std::span<const std::uint32_t> component_of,
                                                   std::span<const std::uint32_t> first_triangle, const std::vector<bool>& crosses_other,
                                                   const Progress& progress) {
  std::vector<std::vector<Enclosure>> result(first_triangle.size());
  if (first_triangle.size() < 2) return result;
  std::vector<Eigen::AlignedBox3d> shadows;  // boxes of the triangles, projected along z
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Eigen::AlignedBox3d box;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d& p = mesh.corner(t, k);
      box.extend(Eigen::Vector3d(p.x(), p.y(), 0));
    }
    shadows.push_back(box);
  }
  const BoxTree tree(shadows);
  for (std::uint32_t c = 0; c < first_triangle.size(); ++c) {
    if (crosses_other[c]) continue;
    progress.check();
    const std::uint32_t vertex = mesh.triangles[first_triangle[c]][0];
    const Eigen::Vector3d& p = mesh.positions[vertex];
    std::map<std::uint32_t, int> windings;
    tree.searchWithin(Eigen::Vector3d(p.x(), p.y(), 0), 0, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count; ++slot) {
        const std::uint32_t t = tree.order()[slot];
        if (component_of[t] != c) windings[component_of[t]] += crossingAbove(mesh, t, p);
      }
    });
    for (const auto& [other, winding] : windings)
      if (winding != 0) result[c].push_back({other, winding});
  }
  return result;
}

}  // namespace spheretree::builder
