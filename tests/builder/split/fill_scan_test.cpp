// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/fill_scan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mesh/crossing_triangles.h"
#include "repair/fill_holes.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/mesh_measures.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// Removes the triangles whose midpoint satisfies `isLeftOut`.
template <class IsLeftOut>
ScanSurface scanOf(TriangleMesh mesh, const IsLeftOut& isLeftOut) {
  std::vector<Triangle> kept;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    if (!isLeftOut((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3)) kept.push_back(mesh.triangles[t]);
  mesh.triangles = kept;
  ScanSurface scan;
  scan.vertex_region.assign(mesh.positions.size(), kGumRegion);
  scan.is_invented.assign(kept.size(), 0);
  scan.mesh = std::move(mesh);
  return scan;
}

std::size_t crossings(const TriangleMesh& mesh) { return findCrossingTriangles(mesh, kMaxCrossingPairs).pairs.size(); }

/// A square sheet z = 0 of 20 by 20 cells of 1 mm.
TriangleMesh sheet() {
  constexpr std::uint32_t kCells = 20;
  TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= kCells; ++j)
    for (std::uint32_t i = 0; i <= kCells; ++i) mesh.positions.emplace_back(i, j, 0);
  for (std::uint32_t j = 0; j < kCells; ++j)
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = j * (kCells + 1) + i, b = a + kCells + 1;
      mesh.triangles.push_back({a, a + 1, b + 1});
      mesh.triangles.push_back({a, b + 1, b});
    }
  return mesh;
}

bool isInHole(const Vector3d& p) { return std::abs(p.x() - 10) < 3 && std::abs(p.y() - 10) < 3; }

TEST(DropCrossings, LeavesASurfaceThatDoesNotCrossItselfAlone) {
  ScanSurface scan = scanOf(test::sphereMesh(3, 3), [](const Vector3d& p) { return p.z() < 0; });
  const std::vector<Triangle> before = scan.mesh.triangles;
  EXPECT_EQ(dropCrossings(scan), 0u);
  EXPECT_EQ(scan.mesh.triangles, before);
}

TEST(DropCrossings, TakesTheTriangleThatCrossesMostOthersFirst) {
  ScanSurface scan = scanOf(sheet(), [](const Vector3d&) { return false; });
  const auto first = static_cast<std::uint32_t>(scan.mesh.positions.size());
  // A blade through many triangles of the sheet: only the blade must be removed.
  scan.mesh.positions.insert(scan.mesh.positions.end(), {{2.3, 5.4, -1}, {15.3, 6.7, -1}, {9.1, 6.1, 4}});
  scan.mesh.triangles.push_back({first, first + 1, first + 2});
  scan.vertex_region.resize(scan.mesh.positions.size(), kGumRegion);
  scan.is_invented.push_back(0);
  ASSERT_GT(crossings(scan.mesh), 10u);
  EXPECT_EQ(dropCrossings(scan), 1u);
  EXPECT_EQ(crossings(scan.mesh), 0u);
  EXPECT_EQ(scan.mesh.triangles, sheet().triangles);
}

TEST(DropCrossings, LeavesNoCrossingOfTwoSheets) {
  TriangleMesh both = sheet();
  const auto first = static_cast<std::uint32_t>(both.positions.size());
  for (const Vector3d& p : sheet().positions) both.positions.emplace_back(p.x(), p.y(), 0.9 * p.x() + 0.1 * p.y() - 9.95);
  for (Triangle t : sheet().triangles) both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  ScanSurface scan = scanOf(both, [](const Vector3d&) { return false; });
  EXPECT_GT(dropCrossings(scan), 20u);
  EXPECT_EQ(crossings(scan.mesh), 0u);
  EXPECT_EQ(dropCrossings(scan), 0u) << "once is enough";
}

TEST(FillScanHoles, FillsAllLoopsButTheLongestAndKeepsTheScan) {
  const auto isHole = [](const Vector3d& p) {
    return p.z() < -1 || (p - Vector3d(0, 0, 3)).norm() < 0.7 || (p - Vector3d(3, 0, 0)).norm() < 0.9;
  };
  ScanSurface scan = scanOf(test::sphereMesh(3, 4), isHole);
  const std::vector<Triangle> before = scan.mesh.triangles;
  EXPECT_EQ(fillScanHoles(scan), 2u);
  EXPECT_EQ(findHoleLoops(scan.mesh).size(), 1u) << "the outer border";
  EXPECT_EQ(crossings(scan.mesh), 0u);
  ASSERT_GT(scan.mesh.triangles.size(), before.size());
  EXPECT_TRUE(std::equal(before.begin(), before.end(), scan.mesh.triangles.begin())) << "nothing is lost";
  ASSERT_EQ(scan.is_invented.size(), scan.mesh.triangles.size());
  for (std::size_t t = 0; t < scan.is_invented.size(); ++t) EXPECT_EQ(scan.is_invented[t] != 0, t >= before.size());
  EXPECT_EQ(scan.vertex_region.size(), scan.mesh.positions.size());
}

TEST(FillScanHoles, AHoleInAPlateIsFilledByItsArea) {
  ScanSurface scan = scanOf(sheet(), isInHole);
  EXPECT_NEAR(surfaceArea(scan.mesh), 400 - 36, 1e-9);
  EXPECT_EQ(fillScanHoles(scan), 1u);
  EXPECT_NEAR(surfaceArea(scan.mesh), 400, 1e-9);
}

// Noise beside a hole can reach through the filling of least bending: another filling goes around it, and no
// triangle of the scan is lost.
TEST(FillScanHoles, AFillingGoesAroundWhatItWouldCross) {
  std::size_t cases = 0, lost = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    test::Random random(seed);
    ScanSurface scan = scanOf(sheet(), isInHole);
    for (Vector3d& p : scan.mesh.positions) p += Vector3d(random.between(-0.4, 0.4), random.between(-0.4, 0.4), random.between(-0.8, 0.8));
    TriangleMesh spanned = scan.mesh;
    for (const auto& loop : findHoleLoops(scan.mesh))
      if (loop.size() < 40)
        for (const Triangle& t : spanLoop(scan.mesh, loop)) spanned.triangles.push_back(t);
    if (crossings(scan.mesh) > 0 || crossings(spanned) == 0) continue;
    ++cases;
    const std::size_t scanned = scan.mesh.triangles.size();
    EXPECT_EQ(fillScanHoles(scan), 1u);
    EXPECT_EQ(crossings(scan.mesh), 0u);
    EXPECT_EQ(findHoleLoops(scan.mesh).size(), 1u) << "the outer border";
    lost += scanned - static_cast<std::size_t>(std::count(scan.is_invented.begin(), scan.is_invented.end(), 0));
  }
  EXPECT_GE(cases, 3u);
  EXPECT_EQ(lost, 0u);
}

// A sheet with a hole that turns back over itself, with a bump that reaches through the hole. The bump is near the hole
// but far along the surface, like the neighbour of a tooth.
TEST(FillScanHoles, AFillingAvoidsAlsoWhatIsNotConnectedNearby) {
  constexpr std::uint32_t kAlong = 60, kAcross = 20;
  constexpr double kTurn = 10 / M_PI;  // radius of the fold, in which ten cells lie
  TriangleMesh mesh;
  for (std::uint32_t i = 0; i <= kAlong; ++i)
    for (std::uint32_t j = 0; j <= kAcross; ++j) {
      const double u = i, y = j, angle = (u - 20) / kTurn;
      if (i <= 20)
        mesh.positions.emplace_back(u, y, 0);
      else if (i <= 30)
        mesh.positions.emplace_back(20 + kTurn * std::sin(angle), y, kTurn * (1 - std::cos(angle)));
      else
        mesh.positions.emplace_back(50 - u, y, 2 * kTurn - 7.2 * std::exp(-(std::pow(40 - u, 2) + std::pow(y - 10, 2)) / 4));
    }
  for (std::uint32_t i = 0; i < kAlong; ++i)
    for (std::uint32_t j = 0; j < kAcross; ++j) {
      const std::uint32_t a = i * (kAcross + 1) + j, b = a + kAcross + 1;
      mesh.triangles.push_back({a, b, b + 1});
      mesh.triangles.push_back({a, b + 1, a + 1});
    }
  ScanSurface scan = scanOf(mesh, [](const Vector3d& p) { return p.z() == 0 && isInHole(p); });
  const std::size_t scanned = scan.mesh.triangles.size();
  ASSERT_EQ(crossings(scan.mesh), 0u);
  EXPECT_EQ(fillScanHoles(scan), 1u);
  EXPECT_EQ(crossings(scan.mesh), 0u);
  EXPECT_EQ(static_cast<std::size_t>(std::count(scan.is_invented.begin(), scan.is_invented.end(), 0)), scanned) << "nothing is lost";
}

// The filling of least bending would cross the blade that stands in the hole.
TEST(FillScanHoles, AFillingThatCannotPassLosesWhatItCrosses) {
  ScanSurface scan = scanOf(sheet(), isInHole);
  const std::size_t scanned = scan.mesh.triangles.size();
  const auto first = static_cast<std::uint32_t>(scan.mesh.positions.size());
  scan.mesh.positions.insert(scan.mesh.positions.end(), {{8, 9.6, -2}, {12, 10.3, -2}, {12, 10.3, 2}, {8, 9.6, 2}});
  scan.mesh.triangles.push_back({first, first + 1, first + 2});
  scan.mesh.triangles.push_back({first, first + 2, first + 3});
  scan.vertex_region.resize(scan.mesh.positions.size(), kGumRegion);
  scan.is_invented.resize(scan.mesh.triangles.size(), 0);
  ASSERT_EQ(crossings(scan.mesh), 0u);
  EXPECT_EQ(fillScanHoles(scan), 1u);
  EXPECT_EQ(crossings(scan.mesh), 0u);
  EXPECT_EQ(findHoleLoops(scan.mesh).size(), 1u) << "the outer border";
  EXPECT_EQ(static_cast<std::size_t>(std::count(scan.is_invented.begin(), scan.is_invented.end(), 0)), scanned) << "only the blade went";
}

}  // namespace
}  // namespace spheretree::builder
