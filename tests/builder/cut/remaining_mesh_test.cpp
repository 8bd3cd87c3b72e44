// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/remaining_mesh.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "builder/cut/paths.h"
#include "geometry/distance_field.h"
#include "spheretree/builder/mesh_checks.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test_paths::depthIn;
using test_paths::wanderingPath;

double solidVolume(const TriangleMesh& mesh) { return DistanceField(mesh).volume(); }

TEST(RemainingMesh, AHoleThroughAPlateHasItsVolume) {
  const TriangleMesh plate = test::boxMesh({-2, -2, -0.5}, {2, 2, 0.5});
  const std::array paths{BurrPath{0.4, {{0.3, 0.2, -3}, {0.3, 0.2, 3}}}};
  Progress progress;
  const RemainingMesh left = remainingMesh(plate, paths, 0.02, progress);
  EXPECT_TRUE(checkMesh(left.mesh, 10, progress).clean());
  EXPECT_LE(left.bound, 0.02);
  EXPECT_NEAR(solidVolume(left.mesh), 16 - std::numbers::pi * 0.16,
              2 * std::numbers::pi * 0.4 * 0.004);  // the simplified wall errs to both sides
  EXPECT_LT(left.mesh.triangles.size(), 5000u);
}

TEST(RemainingMesh, LiesBetweenWhatASmallerAndALargerBurrLeave) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    test::Random random(seed);
    const double tolerance = 0.03;
    const TriangleMesh object = seed % 2 == 0 ? test::boxMesh({-1, -1, -1}, {1, 1, 0.2}) : test::sphereMesh(0.9, 4);
    const std::array paths{wanderingPath(random, 0.2, {-0.8, -0.8, -0.3}, {0.8, 0.8, 0.6}, 80),
                           wanderingPath(random, 0.3, {-0.8, -0.8, 0.0}, {0.8, 0.8, 0.8}, 80)};
    Progress progress;
    const RemainingMesh left = remainingMesh(object, paths, tolerance, progress);
    ASSERT_TRUE(checkMesh(left.mesh, 10, progress).clean()) << seed;
    EXPECT_LE(left.bound, tolerance);
    const DistanceField before(object), after(left.mesh);
    for (int i = 0; i < 20000; ++i) {
      const Vector3d p(random.between(-1.1, 1.1), random.between(-1.1, 1.1), random.between(-1.1, 1.1));
      const double depth = depthIn(paths, p), outside = before.signedDistance(p);
      if (std::abs(depth) <= left.bound || std::abs(outside) < 1e-6) continue;
      EXPECT_EQ(after.signedDistance(p) < 0, depth < 0 && outside < 0) << seed << ' ' << depth << ' ' << outside;
    }
  }
}

TEST(RemainingMesh, WhatWasNotTouchedStaysAsItWas) {
  const TriangleMesh block = test::boxMesh({-1, -1, -1}, {1, 1, 1});
  Progress progress;
  const std::array missed{BurrPath{0.3, {{3, 0, 0}, {3, 1, 0}}}};
  EXPECT_EQ(remainingMesh(block, missed, 0.05, progress).mesh.triangles.size(), 12u);
  EXPECT_EQ(remainingMesh(block, {}, 0.05, progress).mesh.positions, block.positions);
  const std::array all{BurrPath{3, {{0, 0, 0}, {0.1, 0, 0}}}};
  EXPECT_TRUE(remainingMesh(block, all, 0.05, progress).mesh.triangles.empty());
  const std::array within{BurrPath{0.3, {{0, 0, 0}, {0.1, 0, 0}}}};  // a cavity that does not reach the surface
  const RemainingMesh hollow = remainingMesh(block, within, 0.05, progress);
  EXPECT_TRUE(checkMesh(hollow.mesh, 10, progress).clean());
  EXPECT_NEAR(solidVolume(hollow.mesh), 8 - (4 * std::numbers::pi / 3 * 0.027 + std::numbers::pi * 0.09 * 0.1), 0.05 * 1.4);
}

}  // namespace
}  // namespace spheretree::builder
