// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/wrap_surface.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/distance_field.h"
#include "measure/coverage.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;

TEST(WrapSurface, StopsWhenAsked) {
  Progress progress;
  progress.cancel();
  EXPECT_THROW(wrapSurface(boxMesh({0, 0, 0}, {1, 1, 1}), 0.05, 0.01, progress), Cancelled);
}

TEST(WrapSurface, EnclosesTheTrianglesCloselyAndIsClosed) {
  const TriangleMesh soup = test::randomTriangles(20, 0.5, 2);
  const double alpha = 0.15, offset = 0.02;
  Progress progress;
  const TriangleMesh wrap = wrapSurface(soup, alpha, offset, progress);
  EXPECT_TRUE(checkMesh(wrap).clean()) << checkMesh(wrap).summary();
  const DistanceField inside(wrap), triangles(soup);
  for (const SurfacePoint& p : spreadOverSurface(soup, 2000, 1)) EXPECT_LT(inside.signedDistance(p.point), 0);
  for (const Vector3d& p : wrap.positions) EXPECT_LE(triangles.distance(p), 2 * alpha);  // bridges between triangles
  EXPECT_EQ(wrapSurface(soup, alpha, offset, progress).positions, wrap.positions);
}

// A box without its lid: a ball wider than the opening closes it; a smaller one follows the walls on both sides.
TEST(WrapSurface, BridgesOpeningsNarrowerThanTheBall) {
  TriangleMesh open = boxMesh({0, 0, 0}, {1, 1, 1});
  std::erase_if(open.triangles,
                [&](const Triangle& t) { return std::ranges::all_of(t, [&](std::uint32_t v) { return open.positions[v].z() == 1; }); });
  ASSERT_EQ(open.triangles.size(), 10u);
  Progress progress;
  EXPECT_GT(test::volumeOf(wrapSurface(open, 1, 0.01, progress)), 0.7);
  EXPECT_LT(test::volumeOf(wrapSurface(open, 0.1, 0.01, progress)), 5 * 2 * 0.03);  // five walls
}

}  // namespace
}  // namespace spheretree::builder
