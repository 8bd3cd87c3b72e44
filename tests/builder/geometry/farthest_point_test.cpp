// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/farthest_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "measure/coverage.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;

TEST(FarthestFrom, BoundsTheDistanceClosely) {
  const TriangleMesh sphere = test::sphereMesh(1, 4), box = boxMesh({-2, -2, -2}, {2, 2, 2});
  std::vector<std::uint32_t> all(box.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  Progress progress;
  const double bound = farthestFrom(DistanceField(sphere), box, all, 1e-3, progress), exact = std::sqrt(12) - 1;
  EXPECT_GE(bound, exact - 5e-3);  // the mesh of the sphere has facets
  EXPECT_LE(bound, exact * 1.05 + 5e-3);
  EXPECT_LE(farthestFrom(DistanceField(box), box, all, 1e-9, progress), 1e-9);  // at once, although no region is smaller than its bound
}

TEST(ClippedToDepth, RemovesOnlyDeepTriangles) {
  const TriangleMesh box = boxMesh({0, 0, 0}, {10, 10, 10});
  TriangleMesh plane;  // through the middle, and out on all sides
  plane.positions = {{-5, -5, 5}, {25, -5, 5}, {-5, 25, 5}};
  plane.triangles = {{0, 1, 2}};
  const DistanceField field(box);
  Progress progress;
  const TriangleMesh kept = clipToDepth(field, plane, std::vector<std::uint32_t>{0}, 1, progress).pieces;
  const double cut = test::areaOf(plane) - test::areaOf(kept);
  EXPECT_LE(cut, 64);  // the square of 8 mm that is deep
  EXPECT_GE(cut, 49);
  for (std::size_t t = 0; t < kept.triangles.size(); ++t)
    EXPECT_GE(field.signedDistance((kept.corner(t, 0) + kept.corner(t, 1) + kept.corner(t, 2)) / 3), -1.3);
}

TEST(FarthestFrom, AgreesWithManySamples) {
  const DistanceField field(test::sphereMesh(0.5, 2));
  const std::vector<std::uint32_t> some{1, 4, 7, 19};
  Progress progress;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const TriangleMesh soup = test::randomTriangles(20, 1, seed);
    TriangleMesh chosen{soup.positions, {}, {}, {}};
    for (const std::uint32_t t : some) chosen.triangles.push_back(soup.triangles[t]);
    double sampled = 0;
    for (const SurfacePoint& p : spreadOverSurface(chosen, 20000, 1)) sampled = std::max(sampled, field.distance(p.point));
    const double bound = farthestFrom(field, soup, some, 1e-3, progress);
    EXPECT_GE(bound, sampled);
    EXPECT_LE(bound, 1.05 * sampled + 0.05) << seed;  // samples do not reach the corners
  }
}

// Triangles cut by the deep part, wholly inside it, and far from it.
TEST(ClippedToDepth, ReportsRemovedAndCutTriangles) {
  TriangleMesh mesh;
  mesh.positions = {{1, 5, 5}, {19, 5, 5}, {1, 6, 5}, {4, 4, 4}, {6, 4, 4}, {4, 6, 5}, {20, 0, 0}, {21, 0, 0}, {20, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
  Progress progress;
  const PartsNearSurface clipped =
      clipToDepth(DistanceField(boxMesh({0, 0, 0}, {10, 10, 10})), mesh, std::vector<std::uint32_t>{2, 0, 1}, 2, progress);
  EXPECT_EQ(clipped.partly, std::vector<std::uint32_t>{0});
  EXPECT_EQ(clipped.removed, std::vector<std::uint32_t>{1});
}

}  // namespace
}  // namespace spheretree::builder
