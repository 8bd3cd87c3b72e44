// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/mesh_nesting.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "mesh/crossing_triangles.h"
#include "spheretree/core/mesh_edit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;

/// Winding number of a closed mesh round a point by solid angles (A. van Oosterom, J. Strackee, 1983).
int windingOf(const TriangleMesh& mesh, const Eigen::Vector3d& p) {
  double sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Eigen::Vector3d a = mesh.corner(t, 0) - p, b = mesh.corner(t, 1) - p, c = mesh.corner(t, 2) - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return static_cast<int>(std::lround(sum / (4 * std::acos(-1.0))));
}

/// Of two components, the first of `triangles` triangles.
std::vector<std::vector<Enclosure>> enclosuresOf(const TriangleMesh& mesh, std::size_t triangles,
                                                 const std::vector<bool>& crosses_other = {false, false}) {
  std::vector<std::uint32_t> component_of(triangles, 0);
  component_of.resize(mesh.triangles.size(), 1);
  const std::array<std::uint32_t, 2> first_triangle{0, static_cast<std::uint32_t>(triangles)};
  return findEnclosures(mesh, component_of, first_triangle, crosses_other);
}

TEST(MeshNesting, AgreesWithSolidAnglesWhereRaysMeetEdgesAndVertices) {
  // Small boxes on a grid that coincides with that of the large meshes: rays along z meet edges, corners, and faces
  // edge-on.
  const TriangleMesh outers[] = {boxMesh({-4, -4, -4}, {4, 4, 4}), test::torusMesh(4, 2, 8, 8), test::sphereMesh(5, 1)};
  std::size_t inside = 0;
  for (const TriangleMesh& outer : outers) {
    for (int x = -5; x <= 5; ++x) {
      for (int y = -5; y <= 5; ++y) {
        for (const double z : {-6.0, -3.0, -0.25, 0.5, 3.0}) {
          const Vector3d low(x, y, z);
          const TriangleMesh mesh = joined(outer, boxMesh(low, low + Vector3d(0.125, 0.125, 0.125)));
          if (!findCrossingTriangles(mesh, 1).pairs.empty()) continue;
          const auto enclosures = enclosuresOf(mesh, outer.triangles.size());
          const int winding = windingOf(outer, low);
          ASSERT_EQ(enclosures.at(1).size(), winding == 0 ? 0u : 1u) << low.transpose();
          EXPECT_TRUE(enclosures.at(0).empty());
          if (winding == 0) continue;
          EXPECT_EQ(enclosures[1][0].winding, winding);
          ++inside;
        }
      }
    }
  }
  EXPECT_GT(inside, 100u);
}

TEST(MeshNesting, CountsWindingsAndLeavesOutWhatCrosses) {
  TriangleMesh inward = boxMesh({-2, -2, -2}, {2, 2, 2});
  for (Triangle& t : inward.triangles) std::swap(t[0], t[1]);
  const TriangleMesh nested = joined(inward, boxMesh({0, 0, 0}, {1, 1, 1}));
  const auto enclosures = enclosuresOf(nested, 12);
  ASSERT_EQ(enclosures.at(1).size(), 1u);
  EXPECT_EQ(enclosures[1][0].component, 0u);
  EXPECT_EQ(enclosures[1][0].winding, -1);
  EXPECT_TRUE(enclosuresOf(nested, 12, {false, true}).at(1).empty());
}

}  // namespace
}  // namespace spheretree::builder
