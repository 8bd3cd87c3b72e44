// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/untangle_scan.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>

#include "mesh/crossing_triangles.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr double kRadius = 3, kNoise = 0.05;  // edges of sphereMesh(kRadius, 5): about 0.1

ScanSurface scanOf(TriangleMesh mesh) {
  ScanSurface scan;
  scan.vertex_region.assign(mesh.positions.size(), kGumRegion);
  scan.is_invented.assign(mesh.triangles.size(), 0);
  scan.mesh = std::move(mesh);
  return scan;
}

/// The upper half of a sphere, each coordinate of its vertices with normally distributed noise.
ScanSurface noisyDome(unsigned seed) {
  TriangleMesh mesh = test::sphereMesh(kRadius, 5);
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return mesh.positions[t[0]].z() < 0; });
  std::mt19937 random(seed);
  for (Vector3d& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) {
      double sum = -6;
      for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 0x1p32;
      p[axis] += kNoise * sum;
    }
  return scanOf(std::move(mesh));
}

std::size_t crossings(const ScanSurface& scan) { return findCrossingTriangles(scan.mesh, kMaxCrossingPairs).pairs.size(); }

TEST(UntangleScan, LeavesASurfaceThatDoesNotCrossItselfAlone) {
  ScanSurface scan = scanOf(test::sphereMesh(kRadius, 3));
  const TriangleMesh before = scan.mesh;
  EXPECT_EQ(untangleScan(scan).count, 0u);
  EXPECT_EQ(scan.mesh.positions, before.positions);
}

TEST(UntangleScan, SmallMotionsFreeANoisySurface) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    ScanSurface scan = noisyDome(seed);
    const TriangleMesh before = scan.mesh;
    const std::size_t crossed = crossings(scan);
    ASSERT_GT(crossed, 100u);
    const MovedVertices moved = untangleScan(scan);
    EXPECT_LT(crossings(scan), crossed / 50) << seed;
    EXPECT_EQ(scan.mesh.triangles, before.triangles) << "nothing is removed";
    std::size_t count = 0;
    double farthest = 0;
    for (std::size_t v = 0; v < before.positions.size(); ++v) {
      const double distance = (scan.mesh.positions[v] - before.positions[v]).norm();
      count += distance > 0;
      farthest = std::max(farthest, distance);
    }
    EXPECT_EQ(moved.count, count);
    EXPECT_EQ(moved.farthest, farthest);
    EXPECT_LT(moved.farthest, 3.3 * kNoise) << "three deviations, and the error of their estimate";
    EXPECT_LE(moved.mean, moved.farthest);
  }
}

TEST(UntangleScan, TheMotionTurnsAndGrowsWithTheScan) {
  ScanSurface scan = noisyDome(4), turned = scan;
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(2.7, Vector3d::UnitX()) * Eigen::AngleAxisd(0.6, Vector3d::UnitY())).toRotationMatrix();
  for (Vector3d& p : turned.mesh.positions) p = 25.4 * (turn * p);
  const MovedVertices moved = untangleScan(scan), moved_turned = untangleScan(turned);
  EXPECT_EQ(moved_turned.count, moved.count);
  EXPECT_NEAR(moved_turned.farthest, 25.4 * moved.farthest, 1e-6);
  for (std::size_t v = 0; v < scan.mesh.positions.size(); ++v)
    EXPECT_LT((turned.mesh.positions[v] - 25.4 * (turn * scan.mesh.positions[v])).norm(), 1e-6);
}

// Sheets that pass through each other cannot be told apart by small motions; these have no noise, so that little moves.
TEST(UntangleScan, SheetsThatPassThroughEachOtherStay) {
  TriangleMesh both = test::sphereMesh(kRadius, 3);
  const auto first = static_cast<std::uint32_t>(both.positions.size());
  for (const Vector3d& p : test::sphereMesh(kRadius, 3).positions) both.positions.push_back(p + Vector3d(kRadius, 0.1, 0.05));
  for (const Triangle& t : test::sphereMesh(kRadius, 3).triangles) both.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  ScanSurface scan = scanOf(both);
  const MovedVertices moved = untangleScan(scan);
  EXPECT_GT(crossings(scan), 20u);
  EXPECT_LT(moved.farthest, 0.05) << "a tenth of an edge";
}

}  // namespace
}  // namespace spheretree::builder
