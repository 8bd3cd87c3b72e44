// SPDX-License-Identifier: GPL-3.0-or-later
// The surfaces that close a scan and divide its inside: base and walls. Known answers for a field of heights.
#include "split/part_solids.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <functional>

#include "mesh/crossing_triangles.h"
#include "mesh/mesh_edges.h"
#include "split/close_scan.h"
#include "support/field_surface.h"
#include "support/mesh_measures.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// Volume between the triangles that satisfy `counts` and the plane z = 0; exact.
double volumeUnder(const TriangleMesh& mesh, const std::function<bool(std::size_t)>& counts) {
  double volume = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (!counts(t)) continue;
    const Vector3d a = mesh.corner(t, 0), b = mesh.corner(t, 1), c = mesh.corner(t, 2);
    volume += (b - a).cross(c - a).z() / 2 * (a.z() + b.z() + c.z()) / 3;
  }
  return volume;
}

/// True if along every edge as many triangles run one way as the other.
bool isClosed(const TriangleMesh& mesh) {
  bool closed = true;
  const std::vector<Side> sides = sortedSides(mesh);
  forEachEdge(sides, [&](std::size_t first, std::size_t last) {
    int balance = 0;
    for (std::size_t s = first; s < last; ++s) balance += sides[s].forward ? 1 : -1;
    closed = closed && balance == 0;
  });
  return closed;
}

TEST(AddBase, MakesASlabOfTheKnownVolumeHoweverItLies) {
  for (const Vector3d& up : {Vector3d(0, 0, 1), Vector3d(1, -2, 0.5).normalized()}) {
    ScanSurface s = test::fieldOf(5, 0.5, [](double x, double y) { return 0.2 * std::sin(x) * std::sin(y); });
    const double over_zero = volumeUnder(s.mesh, [](std::size_t) { return true; });
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up);
    double lowest = 0;
    for (const Vector3d& p : s.mesh.positions) lowest = std::min(lowest, p.z());
    for (Vector3d& p : s.mesh.positions) p = turn * p + Vector3d(3, 4, 5);
    addBase(s, up, 4);
    EXPECT_TRUE(isClosed(s.mesh));
    EXPECT_NEAR(test::volumeOf(s.mesh), over_zero + 100 * (4 - lowest), 1e-9 * 400);
    EXPECT_EQ(s.region.size(), s.mesh.triangles.size());
  }
}

TEST(FindWalls, TheSolidsFillTheInside) {
  const auto bump = [](double x, double y) { return std::max(0.0, 1 - std::abs(x) / 3) * std::max(0.0, 1 - std::abs(y) / 3) * 2; };
  ScanSurface s = test::fieldOf(6, 0.25, bump);
  test::addRegion(s, [](const Vector3d& p) { return p.head<2>().cwiseAbs().maxCoeff() < 3; });  // its rim: a square of 6 mm, flat
  const double tooth_volume = volumeUnder(s.mesh, [&](std::size_t t) { return s.region[t] == 1; });
  addBase(s, Vector3d::UnitZ(), 4);
  const double whole = test::volumeOf(s.mesh);
  const PartSolids solids = findWalls(s, {Vector3d::UnitZ(), 0});
  std::vector<char> invented;
  const TriangleMesh tooth = solidOf(s, solids, 1, invented), gum = solidOf(s, solids, kGumRegion, invented);
  for (const TriangleMesh& part : {tooth, gum}) {
    EXPECT_TRUE(isClosed(part));
    EXPECT_EQ(findCrossingTriangles(part, 1).pairs.size(), 0u);
  }
  EXPECT_NEAR(test::volumeOf(tooth) + test::volumeOf(gum), whole, 1e-9 * whole);
  // The cap is flat, half an edge of 0.25 mm below the rim.
  EXPECT_NEAR(test::volumeOf(tooth), tooth_volume + 36 * 0.125, 0.05 * 36 * 0.125);
  ASSERT_EQ(solids.rim_length.size(), 2u);
  EXPECT_NEAR(solids.rim_length[1], 24, 1e-9);
}

}  // namespace
}  // namespace spheretree::builder
