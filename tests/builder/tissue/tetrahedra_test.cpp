// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/tetrahedra.h"

#include <gtest/gtest.h>

#include <limits>

#include "spheretree/builder/build_settings.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/shapes.h"
#include "support/tetrahedra.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

TEST(Tetrahedra, TheBoundaryOfABoxIsItsSurface) {
  const Tetrahedra solid = test::boxTetrahedra({4, 3, 5}, {4, 2, 3});
  EXPECT_NEAR(volumeOf(solid), 60, 1e-12);
  std::vector<std::uint32_t> owner;
  const TriangleMesh boundary = boundaryOf(solid, &owner);
  EXPECT_EQ(boundary.triangles.size(), 2u * 2 * (4 * 2 + 4 * 3 + 2 * 3));
  EXPECT_EQ(owner.size(), boundary.triangles.size());
  const MeshReport report = checkMesh(boundary);
  EXPECT_TRUE(report.clean()) << report.summary();
  EXPECT_NEAR(report.volume, 60, 1e-12);  // wound outward
}

TEST(Tetrahedra, AreTurnedAndThoseInACavityDropped) {
  const Tetrahedra whole = test::boxTetrahedra({3, 3, 3}, {3, 3, 3});
  TriangleMesh surface = test::boxMesh(Vector3d::Zero(), Vector3d::Constant(3));
  Tetrahedra found = whole;
  for (std::size_t t = 0; t < found.corners.size(); t += 2) std::swap(found.corners[t][0], found.corners[t][1]);
  EXPECT_EQ(solidOf(found, surface).corners.size(), whole.corners.size());
  EXPECT_NEAR(volumeOf(solidOf(found, surface)), 27, 1e-12);
  const TriangleMesh hollow = test::boxMesh(Vector3d::Constant(1), Vector3d::Constant(2));
  for (const Triangle& t : hollow.triangles) surface.triangles.push_back({t[0] + 8, t[2] + 8, t[1] + 8});
  surface.positions.insert(surface.positions.end(), hollow.positions.begin(), hollow.positions.end());
  EXPECT_NEAR(volumeOf(solidOf(found, surface)), 26, 1e-12);
}

// Above the square of a cell on top, such as a mesher may leave where four points of the surface are coplanar.
TEST(Tetrahedra, FlatOnesAlongTheSurfaceAreDropped) {
  const TriangleMesh surface = test::boxMesh(Vector3d::Zero(), Vector3d::Constant(3));
  const Tetrahedra whole = test::boxTetrahedra({3, 3, 3}, {3, 3, 3});
  Tetrahedra found = whole;
  const auto at = [&](double x, double y) {
    for (std::uint32_t i = 0; i < found.nodes.size(); ++i)
      if ((found.nodes[i] - Vector3d(x, y, 3)).norm() < 1e-9) return i;
    return std::uint32_t{0};
  };
  found.corners.insert(found.corners.begin() + 5, {at(1, 1), at(2, 1), at(2, 2), at(1, 2)});
  const Tetrahedra solid = solidOf(found, surface);
  EXPECT_EQ(solid.corners, whole.corners);
  EXPECT_TRUE(checkMesh(boundaryOf(solid)).clean());
  for (std::size_t t = 0; t < found.corners.size(); ++t)  // a node moved into a plane of its neighbours, inside
    if (found.nodes[found.corners[t][0]] == Vector3d(1, 1, 1)) found.nodes[found.corners[t][0]] = Vector3d(1, 1, 2);
  EXPECT_THROW(solidOf(found, surface), BuildError);
}

TEST(Tetrahedra, RefusesTetrahedraThatDoNotFillTheSurface) {
  const TriangleMesh surface = test::boxMesh(Vector3d::Zero(), Vector3d::Constant(3));
  const Tetrahedra whole = test::boxTetrahedra({3, 3, 3}, {3, 3, 3});
  Tetrahedra broken = whole;
  broken.corners.pop_back();
  EXPECT_THROW(solidOf(broken, surface), BuildError) << "one is missing";
  broken = whole;
  broken.corners[7][2] = static_cast<std::uint32_t>(broken.nodes.size());
  EXPECT_THROW(solidOf(broken, surface), BuildError) << "a node that does not exist";
  broken = whole;
  broken.nodes[5].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(solidOf(broken, surface), BuildError) << "not a number";
  broken = whole;
  broken.corners[3][1] = broken.corners[3][0];
  EXPECT_THROW(solidOf(broken, surface), BuildError) << "flat";
  broken = whole;
  broken.corners.push_back(broken.corners[3]);
  EXPECT_THROW(solidOf(broken, surface), BuildError) << "twice";
}

}  // namespace
}  // namespace spheretree::builder
