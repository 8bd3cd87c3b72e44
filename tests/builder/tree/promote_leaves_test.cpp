// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree/promote_leaves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "certify/certify_cover.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "support/dense_points.h"
#include "support/shapes.h"
#include "tree/hierarchy.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

// A ball that one sphere approximates at any tolerance above that of its facets, next to a ring that needs many
// spheres.
TriangleMesh ballAndRing() { return test::joined(test::moved(test::sphereMesh(2, 4), {0, 0, 9}), test::torusMesh(5, 1, 32, 12)); }

std::vector<Sphere> certified(const TriangleMesh& mesh, const std::vector<Ball>& balls) {
  Progress progress;
  return certifyCover(mesh, balls, Vector3d::Zero(), 1e-3, progress).spheres;
}

bool covers(const TriangleMesh& mesh, const std::vector<Sphere>& spheres) {
  Progress progress;
  return certifyCover(mesh, test::toBalls(spheres, Vector3d::Zero()), Vector3d::Zero(), 1e-3, progress).largest_growth == 0;
}

std::vector<Ball> ring(int count) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    balls.push_back({5 * Vector3d(std::cos(angle), std::sin(angle), 0), 1.1 + 20.0 / (count * count)});
  }
  return balls;
}

// Three levels, of which one leaf covers the whole ball, tighter than the sphere above it.
std::vector<std::vector<Sphere>> certifiedLevels(const TriangleMesh& mesh) {
  std::vector<Ball> inner = ring(5), leaves = ring(24);
  inner.push_back({{0, 0, 9}, 2.5});
  leaves.push_back({{0, 0, 9}, 2.01});
  return {certified(mesh, {{{0, 0, 3}, 12}}), certified(mesh, inner), certified(mesh, leaves)};
}

TEST(PromoteLeaves, ALeafThatCanStandForASphereAboveMovesUp) {
  const TriangleMesh mesh = ballAndRing();
  const std::vector<std::vector<Sphere>> before = certifiedLevels(mesh);
  std::vector<std::vector<Sphere>> levels = before;
  Progress progress;
  EXPECT_EQ(promoteLeaves(mesh, Vector3d::Zero(), 8, 1, levels, progress), (std::vector<std::size_t>{1, 5, 24}));
  EXPECT_EQ(levels[1].back(), before[2].back()) << "the tight sphere about the ball";
  EXPECT_TRUE(covers(mesh, levels[1]));
  EXPECT_EQ(std::count(levels[2].begin(), levels[2].end(), before[2].back()), 0);
}

TEST(PromoteLeaves, NothingMovesWhereTheOthersHaveNoRoomForItsChildren) {
  const TriangleMesh mesh = ballAndRing();
  const std::vector<std::vector<Sphere>> before = certifiedLevels(mesh);
  std::vector<std::vector<Sphere>> levels = before;
  Progress progress;
  EXPECT_EQ(promoteLeaves(mesh, Vector3d::Zero(), 4, 1, levels, progress), (std::vector<std::size_t>{1, 6, 25}));  // 6 x 4 < 25
  EXPECT_EQ(levels, before);
}

TEST(PromoteLeaves, TreesForAToleranceEndWhereAPartIsGoodEnough) {
  const TriangleMesh mesh = ballAndRing();
  for (const BuilderKind kind : {BuilderKind::Cover, BuilderKind::Merge, BuilderKind::Expand, BuilderKind::Grid, BuilderKind::Octree}) {
    SCOPED_TRACE(name(kind));
    BuildSettings settings;
    settings.builder = kind;
    settings.search = kind != BuilderKind::Cover;
    settings.quality = Quality::Quick;
    settings.tolerance_mm = 0.2;
    Progress progress;
    const SphereTree tree = buildSphereTree(mesh, settings, progress).tree;
    EXPECT_EQ(findFault(tree), "");
    ASSERT_GT(tree.levelCount(), 2);
    const std::vector<std::uint32_t> last = levelSet(tree, tree.levelCount() - 1), above = levelSet(tree, tree.levelCount() - 2);
    std::size_t early = 0;
    for (const std::uint32_t node : last) early += std::find(above.begin(), above.end(), node) != above.end();
    EXPECT_GT(early, 0u);
    const std::vector<Vector3d> points = test::densePoints(mesh, 20, 7);
    for (int level = 0; level < tree.levelCount(); ++level) {
      std::vector<Sphere> spheres;
      for (const std::uint32_t node : levelSet(tree, level)) spheres.push_back(tree.cover[node]);
      EXPECT_LE(test::largestGap(points, test::toBalls(spheres, Vector3d::Zero())), 1e-14) << "level " << level;
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
