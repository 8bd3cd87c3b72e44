// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/build_by_regions.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "build_levels.h"
#include "support/dense_points.h"
#include "support/regions.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct Named {
  std::string name;
  std::vector<Method> methods;
};

std::vector<Named> allMethods() {
  std::vector<Named> all;
  for (const BuilderKind kind :
       {BuilderKind::Merge, BuilderKind::Burst, BuilderKind::Expand, BuilderKind::Spawn, BuilderKind::Grid, BuilderKind::Hubbard})
    all.push_back({std::string(name(kind)), {methodOf(kind)}});
  all.push_back({"combined", {}});
  for (const BuilderKind kind : kUsualMembers) all.back().methods.push_back(methodOf(kind));
  return all;
}

BuildSettings quick(int levels) {
  BuildSettings settings;
  settings.levels = levels;
  settings.quality = Quality::Quick;
  return settings;
}

LevelBalls built(const TriangleMesh& mesh, const DistanceField& field, std::span<const Method> methods, const BuildSettings& settings) {
  Progress progress;
  return buildByRegions(mesh, field, methods, settings, progress);
}

// The balls of a level and those above it that end.
std::vector<Ball> levelSetOf(const LevelBalls& tree, std::size_t level) {
  std::vector<Ball> set = tree.balls[level];
  for (std::size_t above = 0; above < level; ++above) {
    std::vector<char> has_child(tree.balls[above].size(), 0);
    for (const std::uint32_t parent : tree.parents[above + 1]) has_child[parent] = 1;
    for (std::size_t i = 0; i < has_child.size(); ++i)
      if (!has_child[i]) set.push_back(tree.balls[above][i]);
  }
  return set;
}

double worstOf(const LevelBalls& tree, std::size_t level, const DistanceField& field) {
  double worst = 0;
  for (const Ball& b : levelSetOf(tree, level)) worst = std::max(worst, b.radius + field.signedDistance(b.centre));
  return worst;
}

std::size_t countAll(const LevelBalls& tree) {
  std::size_t count = 0;
  for (const auto& level : tree.balls) count += level.size();
  return count;
}

void expectSound(const LevelBalls& tree, const TriangleMesh& mesh, const DistanceField& field, const BuildSettings& settings) {
  ASSERT_LE(tree.balls.size(), static_cast<std::size_t>(settings.levels));
  ASSERT_EQ(tree.parents.size(), tree.balls.size());
  ASSERT_EQ(tree.balls[0].size(), 1u);
  const std::vector<Vector3d> points = test::densePoints(mesh, 6, 5);
  for (std::size_t level = 0; level < tree.balls.size(); ++level) {
    SCOPED_TRACE("level " + std::to_string(level));
    ASSERT_EQ(tree.parents[level].size(), tree.balls[level].size());
    for (const Ball& b : tree.balls[level]) {
      EXPECT_TRUE(b.centre.allFinite());
      EXPECT_TRUE(std::isfinite(b.radius));
      EXPECT_GT(b.radius, 0);
    }
    if (level > 0) {
      std::vector<int> children(tree.balls[level - 1].size(), 0);
      for (const std::uint32_t parent : tree.parents[level]) ++children.at(parent);
      EXPECT_LE(*std::ranges::max_element(children), settings.branching);
    }
    // The level covers the surface, up to gaps between the points that the method samples.
    const std::vector<Ball> set = levelSetOf(tree, level);
    double gap = 0;
    for (const Vector3d& p : points) {
      double nearest = kInfinity;
      for (const Ball& b : set) nearest = std::min(nearest, (p - b.centre).norm() - b.radius);
      gap = std::max(gap, nearest);
    }
    EXPECT_LE(gap, std::max(0.5 * worstOf(tree, level, field), 0.02 * field.diagonal()));
  }
}

TEST(BuildByRegions, EveryMethodMakesASoundTree) {
  for (const TriangleMesh& mesh :
       {test::boxMesh({0, 0, 0}, {1, 2, 3}), test::boxMesh({0, 0, 0}, {1, 1, 0.01}), test::torusMesh(5, 1, 24, 10)}) {
    const DistanceField field(mesh);
    for (const Named& named : allMethods()) {
      SCOPED_TRACE(named.name + ", " + std::to_string(mesh.triangles.size()) + " triangles");
      const LevelBalls tree = built(mesh, field, named.methods, quick(3));
      expectSound(tree, mesh, field, quick(3));
      ASSERT_EQ(tree.balls.size(), 3u);
      // Deeper levels are finer.
      EXPECT_LT(worstOf(tree, 1, field), worstOf(tree, 0, field));
      EXPECT_LT(worstOf(tree, 2, field), worstOf(tree, 1, field));
    }
  }
}

// What the levels of a tree show: methods differ. A merge has other balls than a grid, and so has every pair.
TEST(BuildByRegions, NoTwoMethodsMakeTheSameTree) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 2, 3});
  const DistanceField field(mesh);
  std::vector<double> worst;
  for (const Named& named : allMethods())
    if (named.name != "combined") worst.push_back(worstOf(built(mesh, field, named.methods, quick(4)), 3, field));
  std::ranges::sort(worst);
  for (std::size_t i = 1; i < worst.size(); ++i) EXPECT_GT(worst[i], worst[i - 1]);
  EXPECT_GT(worst.back(), 2 * worst.front());
}

TEST(BuildByRegions, SameBallsForAnyNumberOfThreads) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  for (const Named& named : allMethods()) {
    SCOPED_TRACE(named.name);
    std::vector<LevelBalls> trees;
    for (const std::size_t threads : {1, 4}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      trees.push_back(built(mesh, field, named.methods, quick(3)));
    }
    for (std::size_t t = 1; t < trees.size(); ++t) {
      EXPECT_EQ(trees[t].parents, trees[0].parents);
      ASSERT_EQ(trees[t].balls.size(), trees[0].balls.size());
      for (std::size_t level = 0; level < trees[0].balls.size(); ++level) {
        ASSERT_EQ(trees[t].balls[level].size(), trees[0].balls[level].size());
        for (std::size_t i = 0; i < trees[0].balls[level].size(); ++i) {
          EXPECT_EQ(trees[t].balls[level][i].centre, trees[0].balls[level][i].centre);
          EXPECT_EQ(trees[t].balls[level][i].radius, trees[0].balls[level][i].radius);
        }
      }
    }
  }
}

TEST(BuildByRegions, AnyBranching) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {3, 2, 1});
  const DistanceField field(mesh);
  const std::vector<Method> methods{methodOf(BuilderKind::Expand)};
  for (const int branching : {2, 3, 5}) {
    BuildSettings settings = quick(4);
    settings.branching = branching;
    expectSound(built(mesh, field, methods, settings), mesh, field, settings);
  }
}

TEST(BuildByRegions, ASphereNeedsOneBall) {
  const TriangleMesh mesh = test::sphereMesh(2, 4);
  const DistanceField field(mesh);
  BuildSettings settings = quick(4);
  settings.tolerance_mm = 0.05;  // above the error of the facets
  EXPECT_EQ(built(mesh, field, std::vector<Method>{methodOf(BuilderKind::Merge)}, settings).balls.size(), 1u);
}

TEST(BuildByRegions, ALooserToleranceTakesFewerBalls) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  std::size_t before = 0;
  for (const double tolerance : {0.0, 0.4, 0.8}) {
    BuildSettings settings = quick(4);
    settings.tolerance_mm = tolerance;
    const LevelBalls tree = built(mesh, field, std::vector<Method>{methodOf(BuilderKind::Expand)}, settings);
    const std::size_t count = countAll(tree);
    if (before > 0) {
      EXPECT_LT(count, before) << "tolerance " << tolerance;
    }
    before = count;
    if (tolerance > 0) {
      EXPECT_LE(worstOf(tree, tree.balls.size() - 1, field), tolerance);
    }
  }
}

// The thesis: combined takes the best of its members for each node. Regions are caps of shapes, as nodes have them.
TEST(BuildByRegions, CombinedIsInNoRegionWorseThanAMember) {
  const std::vector<Method> methods = allMethods().back().methods;
  std::vector<int> won(methods.size(), 0);
  for (const TriangleMesh& mesh : {test::torusMesh(5, 1, 24, 10), test::boxMesh({-1, -2, -3}, {1, 2, 3}), test::sphereMesh(2, 3)}) {
    const test::WholeRegion whole(mesh, 2000);
    for (std::size_t cap = 0; cap < 6; ++cap) {
      const Region all = whole.region(8);
      const Vector3d middle = all.points[cap * all.points.size() / 6];
      std::vector<Vector3d> points;
      for (const Vector3d& p : all.points)
        if ((p - middle).norm() < 1.5) points.push_back(p);
      Region region = all;
      region.points = points;
      Progress progress;
      const std::vector<std::span<const FittedBall>> pools(methods.size(), all.pool);
      const double together = worstOverhang(reduceRegion(region, methods, pools, progress));
      double best = kInfinity;
      std::size_t winner = 0;
      for (std::size_t m = 0; m < methods.size(); ++m) {
        const double own = worstOverhang(reduceRegion(region, std::span(methods).subspan(m, 1), std::span(pools).subspan(m, 1), progress));
        EXPECT_LE(together, own);
        if (own < best) best = own, winner = m;
      }
      EXPECT_EQ(together, best);
      ++won[winner];
    }
  }
  EXPECT_GT(std::ranges::count_if(won, [](int count) { return count > 0; }), 1) << "one member alone would do";
}

// The claim of ACM TOG 2004, over methods and shapes: the geometric mean of the ratios.
TEST(BuildByRegions, TheAdaptiveMedialAxisIsBetterThanAStaticOne) {
  double logs = 0;
  int count = 0;
  for (const TriangleMesh& mesh :
       {test::torusMesh(5, 1, 48, 20), test::boxMesh({-1, -2, -3}, {1, 2, 3}), test::boxMesh({0, 0, 0}, {9, 1, 1})}) {
    const DistanceField field(mesh);
    for (const BuilderKind kind : kUsualMembers) {
      const std::vector<Method> methods{methodOf(kind)};
      BuildSettings settings = quick(4);
      const double adaptive = worstOf(built(mesh, field, methods, settings), 3, field);
      settings.medial_axis = MedialAxis::Static;
      logs += std::log(worstOf(built(mesh, field, methods, settings), 3, field) / adaptive);
      ++count;
    }
  }
  EXPECT_GT(std::exp(logs / count), 1.1);
}

TEST(BuildByRegions, RefusesNoMethod) {
  const TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  EXPECT_THROW(built(mesh, DistanceField(mesh), {}, {}), std::invalid_argument);
}

TEST(BuildByRegions, CanBeCancelled) {
  const TriangleMesh mesh = test::torusMesh(5, 1, 24, 10);
  const DistanceField field(mesh);
  Progress progress;
  progress.cancel();
  EXPECT_THROW(buildByRegions(mesh, field, std::vector<Method>{methodOf(BuilderKind::Merge)}, {}, progress), Cancelled);
}

// Shapes on which other programs crash or leave most of the surface uncovered: thin, slender, with a hole.
TEST(BuildByRegions, ShapesThatBreakOthers) {
  for (const TriangleMesh& mesh : {test::quartered(test::quartered(test::boxMesh({0, 0, 0}, {40, 30, 0.5}))),
                                   test::quartered(test::boxMesh({0, 0, 0}, {1, 1, 40})), test::torusMesh(20, 3, 32, 12)}) {
    const DistanceField field(mesh);
    for (const Named& named : allMethods()) {
      if (named.name != "merge" && named.name != "expand") continue;
      SCOPED_TRACE(named.name);
      expectSound(built(mesh, field, named.methods, quick(4)), mesh, field, quick(4));
    }
  }
}

}  // namespace
}  // namespace spheretree::builder
