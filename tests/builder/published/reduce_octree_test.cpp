// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/reduce_octree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "certify/certify_cover.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

TEST(ReduceOctree, CubeIsKnown) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const DistanceField field(mesh);
  Progress progress;
  const LevelBalls tree = buildOctree(mesh, field, {}, progress);
  ASSERT_EQ(tree.balls.size(), 4u);
  const std::size_t counts[] = {1, 8, 56, 296};  // cells of an n x n x n grid that touch the outside
  for (std::size_t level = 0; level < 4; ++level) {
    EXPECT_EQ(tree.balls[level].size(), counts[level]);
    const double cell = std::pow(0.5, static_cast<double>(level));
    for (const Ball& b : tree.balls[level]) EXPECT_LE(b.radius + field.signedDistance(b.centre), (std::sqrt(0.75) - 0.5) * cell + 1e-9);
  }
}

TEST(ReduceOctree, EveryLevelCoversByItself) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 30, 12);
  const DistanceField field(mesh);
  Progress progress;
  for (const int branching : {2, 5, 8}) {
    BuildSettings settings;
    settings.branching = branching;
    const LevelBalls tree = buildOctree(mesh, field, settings, progress);
    for (std::size_t level = 0; level < tree.balls.size(); ++level) {
      const CertifiedCover cover = certifyCover(mesh, tree.balls[level], Eigen::Vector3d::Zero(), 1e-3, progress);
      EXPECT_LT(cover.largest_growth, 1e-2) << "rounding, and pieces cut where the cells meet";
      if (level == 0) continue;
      std::vector<int> children(tree.balls[level - 1].size(), 0);
      for (const std::uint32_t parent : tree.parents[level]) ++children.at(parent);
      EXPECT_LE(*std::max_element(children.begin(), children.end()), branching);
    }
  }
}

// A plate in the middle of the cube: each level has two layers of cubes, above and below the middle of the plate.
TEST(ReduceOctree, TheCubeIsAboutTheMiddle) {
  const TriangleMesh mesh = test::boxMesh({5, 5, 5}, {6, 6, 5.01});
  const DistanceField field(mesh);
  Progress progress;
  const LevelBalls tree = buildOctree(mesh, field, {}, progress);
  const std::size_t counts[] = {1, 8, 32, 128};
  for (std::size_t level = 0; level < 4; ++level) {
    EXPECT_EQ(tree.balls[level].size(), counts[level]);
    const double half = 0.5 * std::pow(0.5, static_cast<double>(level));
    for (const Ball& b : tree.balls[level]) {
      EXPECT_NEAR(b.radius, std::sqrt(3) * half, 1e-9);
      EXPECT_NEAR(std::abs(b.centre.z() - 5.005), level == 0 ? 0 : half, 1e-9);
    }
  }
}

TEST(ReduceOctree, CellsThatKeepTheToleranceAreNotDivided) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 30, 12);
  const DistanceField field(mesh);
  BuildSettings settings;
  settings.levels = 5;
  settings.tolerance_mm = 1;
  Progress progress;
  const LevelBalls tree = buildOctree(mesh, field, settings, progress);
  for (std::size_t level = 1; level < tree.balls.size(); ++level)
    for (const std::uint32_t parent : tree.parents[level]) {
      const Ball& above = tree.balls[level - 1][parent];
      EXPECT_GT(above.radius + field.signedDistance(above.centre), settings.tolerance_mm);
    }
}

}  // namespace
}  // namespace spheretree::builder
