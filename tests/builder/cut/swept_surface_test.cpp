// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/swept_surface.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "builder/cut/paths.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/mesh_checks.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test_paths::depthIn;
using test_paths::wanderingPath;

TEST(SweptSurface, ABallHasItsVolumeAndArea) {
  const std::vector<Capsule> ball{{{0.1, 0.2, 0.3}, {0.1, 0.2, 0.3}, 0.5}};
  Progress progress;
  const TriangleMesh mesh = sweptSurface(ball, 0.001, progress);
  EXPECT_TRUE(checkMesh(mesh, 10, progress).clean());
  const double truth = std::numbers::pi / 6;
  EXPECT_NEAR(DistanceField(mesh).volume(), truth, std::numbers::pi * 0.001);  // the area times the tolerance
  for (const Vector3d& p : mesh.positions) EXPECT_NEAR((p - ball[0].from).norm(), 0.5, 3e-5);
}

TEST(SweptSurface, EnclosesSmallerCapsulesAndIsWithinLargerOnes) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    test::Random random(seed);
    const std::array paths{wanderingPath(random, 0.2, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 40),
                           wanderingPath(random, 0.31, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 40)};
    const std::vector<Capsule> capsules = sweptCapsules(paths, 0);
    Progress progress;
    const TriangleMesh mesh = sweptSurface(capsules, 0.03, progress);
    ASSERT_TRUE(checkMesh(mesh, 10, progress).clean());
    const DistanceField field(mesh);
    for (int i = 0; i < 20000; ++i) {
      const Vector3d p(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1));
      const double depth = depthIn(paths, p);
      if (std::abs(depth) <= 0.03) continue;
      EXPECT_EQ(field.signedDistance(p) < 0, depth > 0) << seed << ' ' << depth;
    }
  }
}

TEST(SweptSurface, IsTheSameForAnyNumberOfThreads) {
  test::Random random(5);
  const std::array paths{wanderingPath(random, 0.2, {-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}, 60)};
  const std::vector<Capsule> capsules = sweptCapsules(paths, 1e-4);
  Progress progress;
  const TriangleMesh many = sweptSurface(capsules, 0.02, progress);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const TriangleMesh single = sweptSurface(capsules, 0.02, progress);
  EXPECT_EQ(many.triangles, single.triangles);
  EXPECT_EQ(many.positions, single.positions);
}

}  // namespace
}  // namespace spheretree::builder
