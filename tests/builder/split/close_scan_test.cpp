// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/close_scan.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mesh/crossing_triangles.h"
#include "spheretree/builder/mesh_checks.h"
#include "split/fill_scan.h"
#include "support/field_surface.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

double flatHeight(double, double) { return 0; }

std::size_t crossingsOf(const TriangleMesh& mesh) { return findCrossingTriangles(mesh, kMaxCrossingPairs).pairs.size(); }

/// A sheet whose side x > 3 is curled up and back, to 172 degrees: its border hangs over the sheet.
ScanSurface curledSheet() {
  ScanSurface s = test::fieldOf(4.5, 0.25, flatHeight);
  for (Vector3d& p : s.mesh.positions)
    if (const double angle = (p.x() - 3) / 0.5; angle > 0) p.x() = 3 + 0.5 * std::sin(angle), p.z() = 0.5 * (1 - std::cos(angle));
  return s;
}

TEST(FindOuterLoop, IsTheLongestOneOfTheLargestPiece) {
  const auto isThere = [](const Vector3d& p) { return p.head<2>().cwiseAbs().maxCoeff() > 2; };
  TriangleMesh mesh = test::fieldOf(5, 0.5, flatHeight, isThere).mesh;
  const auto outer = findOuterLoop(mesh);
  EXPECT_EQ(outer.size(), 80u);
  for (const std::uint32_t v : outer) EXPECT_NEAR(mesh.positions[v].head<2>().cwiseAbs().maxCoeff(), 5, 1e-12);
  for (std::size_t i = 0; i < outer.size(); ++i)  // opposite to the sheet, which is seen from above
    EXPECT_LT(mesh.positions[outer[i]].cross(mesh.positions[outer[(i + 1) % outer.size()]]).z(), 0);
  // A strip of 90 x 0.5 mm has a longer border, but less area than 84 mm^2; as a strip of 90 x 1 mm it has more.
  for (const double width : {0.5, 1.0}) {
    TriangleMesh both = mesh;
    const auto first = static_cast<std::uint32_t>(both.positions.size());
    for (const Vector3d& p : {Vector3d(20, 0, 0), Vector3d(110, 0, 0), Vector3d(110, width, 0), Vector3d(20, width, 0)})
      both.positions.push_back(p);
    both.triangles.insert(both.triangles.begin(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
    EXPECT_EQ(findOuterLoop(both).size(), width < 1 ? 80u : 4u);
    EXPECT_EQ(findOuterLoop(both) == outer, width < 1);
  }
}

TEST(FindOuterLoop, IsEmptyWithoutABorder) {
  EXPECT_TRUE(findOuterLoop(test::sphereMesh(3, 2)).empty());
  EXPECT_TRUE(findOuterLoop({}).empty());
}

TEST(ClearBase, LeavesAScanAloneThatTheBaseDoesNotCross) {
  ScanSurface s = test::fieldOf(5, 0.5, [](double x, double y) { return std::sin(x) * std::cos(y); });
  const std::vector<Triangle> before = s.mesh.triangles;
  clearBase(s, Vector3d::UnitZ(), 4);
  EXPECT_EQ(s.mesh.triangles, before);
  ScanSurface closed{test::sphereMesh(3, 2), {}, {}, {}, {}, {}};
  clearBase(closed, Vector3d::UnitZ(), 4);
  EXPECT_EQ(closed.mesh.triangles, test::sphereMesh(3, 2).triangles);
}

TEST(ClearBase, LeavesCrossingsOfTheScanWithItselfAlone) {
  ScanSurface s = test::fieldOf(5, 0.5, flatHeight);
  std::swap(s.mesh.positions[10 * 21 + 2], s.mesh.positions[10 * 21 + 3]);  // two vertices within, near the border
  ASSERT_GT(crossingsOf(s.mesh), 0u);
  const std::vector<Triangle> before = s.mesh.triangles;
  clearBase(s, Vector3d::UnitZ(), 4);
  EXPECT_EQ(s.mesh.triangles, before);
}

TEST(ClearBase, TrimsABorderThatHangsOverTheScan) {
  ScanSurface s = curledSheet(), untrimmed = s;
  ASSERT_EQ(crossingsOf(s.mesh), 0u);
  addBase(untrimmed, Vector3d::UnitZ(), 4);
  EXPECT_GT(crossingsOf(untrimmed.mesh), 0u) << "otherwise there is nothing to trim";
  clearBase(s, Vector3d::UnitZ(), 4);
  const auto outer = findOuterLoop(s.mesh);
  for (const std::uint32_t v : outer) EXPECT_LT(s.mesh.positions[v].x(), 3.01) << "the sheet now ends before it curls up";
  EXPECT_EQ(s.is_invented, std::vector<char>(s.mesh.triangles.size(), 0));
  std::size_t inner = 0;
  for (std::size_t t = 0; t < s.mesh.triangles.size(); ++t) inner += s.mesh.corner(t, 0).x() < 1.9 && s.mesh.corner(t, 1).x() < 1.9;
  EXPECT_GT(inner, 1700u) << "only the rim is trimmed";
  EXPECT_EQ(fillScanHoles(s), 1u) << "the border of the rim, which is now a piece of its own";
  s.region.clear();
  addBase(s, Vector3d::UnitZ(), 4);
  EXPECT_TRUE(test::isClosed(s.mesh));
  EXPECT_EQ(crossingsOf(s.mesh), 0u);
}

TEST(AddBase, MakesASlabOfTheKnownVolumeHoweverItLies) {
  for (const Vector3d& up : {Vector3d(0, 0, 1), Vector3d(1, -2, 0.5).normalized()}) {
    ScanSurface s = test::fieldOf(5, 0.5, [](double x, double y) { return 0.2 * std::sin(x) * std::sin(y); });
    const double over_zero = test::volumeUnder(s.mesh, [](std::size_t) { return true; });
    const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), up);
    double lowest = 0;
    for (const Vector3d& p : s.mesh.positions) lowest = std::min(lowest, p.z());
    for (Vector3d& p : s.mesh.positions) p = turn * p + Vector3d(3, 4, 5);
    const std::vector<Triangle> scan = s.mesh.triangles;
    const std::size_t vertices = s.mesh.positions.size();
    addBase(s, up, 4);
    EXPECT_TRUE(test::isClosed(s.mesh));
    EXPECT_EQ(crossingsOf(s.mesh), 0u);
    EXPECT_NEAR(test::volumeOf(s.mesh), over_zero + 100 * (4 - lowest), 1e-9 * 400);
    ASSERT_EQ(s.mesh.positions.size(), vertices + 80) << "one below each vertex of the border";
    for (std::size_t v = vertices; v < s.mesh.positions.size(); ++v)
      EXPECT_NEAR((s.mesh.positions[v] - Vector3d(3, 4, 5)).dot(up), lowest - 4, 1e-12) << "the base is plane";
    EXPECT_TRUE(std::equal(scan.begin(), scan.end(), s.mesh.triangles.begin())) << "the scan stays";
    ASSERT_EQ(s.is_invented.size(), s.mesh.triangles.size());
    for (std::size_t t = 0; t < s.is_invented.size(); ++t) EXPECT_EQ(s.is_invented[t] != 0, t >= scan.size());
    EXPECT_EQ(s.region, std::vector<std::int32_t>(s.mesh.triangles.size(), kGumRegion));
  }
}

// Two vertices of the border have changed places, so that its outline crosses itself.
TEST(AddBase, SmoothsAnOutlineThatCrossesItself) {
  ScanSurface s = test::fieldOf(5, 0.5, flatHeight);
  const std::size_t vertices = s.mesh.positions.size(), scanned = s.mesh.triangles.size();
  std::swap(s.mesh.positions[8], s.mesh.positions[11]);
  addBase(s, Vector3d::UnitZ(), 4);
  EXPECT_EQ(s.mesh.positions.size(), vertices + 80) << "no vertex in the middle, from which a fan would span the base";
  double area = 0;
  std::size_t floor = 0;
  for (std::size_t t = scanned; t < s.mesh.triangles.size(); ++t) {
    if (*std::min_element(s.mesh.triangles[t].begin(), s.mesh.triangles[t].end()) < vertices) continue;  // of the wall
    ++floor;
    const Vector3d a = s.mesh.corner(t, 0), across = (s.mesh.corner(t, 1) - a).cross(s.mesh.corner(t, 2) - a);
    EXPECT_LT(across.z(), 0) << "seen from below";
    area -= across.z() / 2;
  }
  EXPECT_EQ(floor, 78u) << "80 vertices";
  EXPECT_GT(area, 95);
  EXPECT_LT(area, 100) << "smoothing rounds the corners of the square";
  EXPECT_TRUE(test::isClosed(s.mesh));
}

TEST(AddBase, AddsNothingToAClosedSurface) {
  ScanSurface closed{test::sphereMesh(3, 2), {}, {}, std::vector<char>(128, 0), {}, {}};
  addBase(closed, Vector3d::UnitZ(), 4);
  EXPECT_EQ(closed.mesh.triangles, test::sphereMesh(3, 2).triangles);
}

}  // namespace
}  // namespace spheretree::builder
