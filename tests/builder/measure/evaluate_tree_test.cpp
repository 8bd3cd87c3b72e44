// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/evaluate_tree.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <tuple>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// The cube [-1, 1]^3: a ball around it, and eight of radius `leaf_radius` about the middles of its octants.
SphereTree octantTree(float leaf_radius, float bound_radius) {
  SphereTree tree;
  tree.branching = 8;
  tree.cover.push_back({0, 0, 0, 1.75f});
  tree.bound.push_back({0, 0, 0, bound_radius});
  for (int k = 0; k < 8; ++k) tree.cover.push_back({k & 1 ? 0.5f : -0.5f, k & 2 ? 0.5f : -0.5f, k & 4 ? 0.5f : -0.5f, leaf_radius});
  tree.bound_index.assign(9, kNone);
  tree.bound_index[0] = 0;
  tree.first_child.assign(9, 0);
  tree.first_child[0] = 1;
  tree.child_count.assign(9, 0);
  tree.child_count[0] = 8;
  tree.level_begin = {0, 1, 9};
  tree.statistics.resize(2);
  return tree;
}

const TriangleMesh kCube = test::boxMesh({-1, -1, -1}, {1, 1, 1});

Evaluation evaluate(const TriangleMesh& mesh, const SphereTree& tree, const EvaluateSettings& settings = {}) {
  Progress progress;
  return evaluateTree(mesh, tree, settings, progress);
}

std::string figures(const Evaluation& e) {
  std::string text = std::to_string(e.diagonal);
  const auto add = [&](double value) { text += ' ' + std::to_string(std::bit_cast<std::uint64_t>(value)); };
  for (const LevelEvaluation& l : e.levels) {
    text += '\n' + std::to_string(l.spheres);
    for (const double v : {l.overhang.max, l.overhang.bound, l.overhang.p99, l.overhang.mean, l.coverage.uncovered_fraction,
                           l.coverage.max_gap, l.coverage.max_gap_bound, l.excess_volume_fraction, l.missing_volume_fraction})
      add(v);
  }
  if (e.limits) add(e.limits->h_fin), add(e.limits->h_low);
  return text;
}

TEST(EvaluateTree, OctantsOfACubeGiveTheClosedForms) {
  const float radius = 0.9f;  // above sqrt(3) / 2: each ball covers its octant
  const Evaluation e = evaluate(kCube, octantTree(radius, 1.8f));
  ASSERT_EQ(e.levels.size(), 2u);
  EXPECT_DOUBLE_EQ(e.diagonal, std::sqrt(12.0));
  EXPECT_EQ(e.levels[0].spheres, 1u);
  EXPECT_EQ(e.levels[1].spheres, 8u);
  EXPECT_NEAR(e.levels[0].overhang.max, 0.75, 1e-6);
  EXPECT_NEAR(e.levels[1].overhang.max, static_cast<double>(radius) - 0.5, 1e-6);
  for (const LevelEvaluation& level : e.levels) {
    EXPECT_GE(level.overhang.bound, level.overhang.max);
    EXPECT_LE(level.overhang.bound, 1.001 * level.overhang.max);
    EXPECT_EQ(level.coverage.uncovered_fraction, 0);
    EXPECT_EQ(level.coverage.max_gap, 0);
    EXPECT_NEAR(level.missing_volume_fraction, 0, 1e-9);
  }
  EXPECT_NEAR(e.levels[0].excess_volume_fraction, 4 * std::numbers::pi / 3 * std::pow(1.75, 3) / 8 - 1, 1e-3);
  ASSERT_TRUE(e.limits.has_value());
  EXPECT_GT(e.limits->h_fin, 0);
}

// A wall in the input beside the cube that the leaves do not reach: its area is half of one side of the cube. No part
// of the spheres is nearer to it than to the cube.
TEST(EvaluateTree, AdditionalTrianglesCount) {
  TriangleMesh wall;
  wall.positions = {{4, -1, -1}, {4, 1, -1}, {4, 1, 1}, {4, -1, 1}};
  wall.triangles = {{0, 1, 2}, {0, 2, 3}};
  const SphereTree tree = octantTree(0.9f, 1.8f);
  const Evaluation without = evaluate(kCube, tree);
  Progress progress;
  const Evaluation with = evaluateTree(kCube, tree, {}, progress, wall);
  EXPECT_DOUBLE_EQ(with.diagonal, std::sqrt(33.0)) << "of both";
  for (std::size_t l = 0; l < 2; ++l) {
    EXPECT_EQ(without.levels[l].coverage.uncovered_fraction, 0);
    EXPECT_NEAR(with.levels[l].coverage.uncovered_fraction, 4.0 / (24 + 4), 1e-4);
    EXPECT_EQ(with.levels[l].overhang.max, without.levels[l].overhang.max);
    EXPECT_EQ(with.levels[l].excess_volume_fraction, without.levels[l].excess_volume_fraction);
  }
  // From a corner of the wall to the nearest leaf, and to the root.
  EXPECT_NEAR(with.levels[1].coverage.max_gap, Eigen::Vector3d(3.5, 0.5, 0.5).norm() - 0.9, 1e-4);
  EXPECT_NEAR(with.levels[0].coverage.max_gap, std::sqrt(18.0) - 1.75, 1e-4);
}

TEST(EvaluateTree, GapsShow) {
  const Evaluation e = evaluate(kCube, octantTree(0.6f, 1.8f), {.limits = false});
  EXPECT_GT(e.levels[1].coverage.uncovered_fraction, 0.1);
  EXPECT_NEAR(e.levels[1].coverage.max_gap, std::sqrt(0.75) - static_cast<double>(0.6f), 1e-5);
  EXPECT_GT(e.levels[1].missing_volume_fraction, 0.1);
  EXPECT_FALSE(e.limits.has_value());
}

TEST(EvaluateTree, CountsLeavesOutsideTheirAncestors) {
  // A leaf reaches sqrt(3) / 2 + 0.9 = 1.766 from the middle: beyond the root's cover sphere, and beyond a tight bound.
  const HierarchyEvaluation wide = evaluate(kCube, octantTree(0.9f, 1.8f), {.limits = false}).hierarchy;
  EXPECT_EQ(wide.leaves, 8u);
  EXPECT_EQ(wide.leaves_outside_ancestor, 0u);
  EXPECT_EQ(wide.leaves_outside_ancestor_cover, 8u);
  EXPECT_EQ(evaluate(kCube, octantTree(0.9f, 1.76f), {.limits = false}).hierarchy.leaves_outside_ancestor, 8u);
}

TEST(EvaluateTree, LeavesOfEarlierLevelsStayInTheLevelSet) {
  SphereTree tree = octantTree(0.9f, 1.8f);
  tree.cover.push_back({0.5f, 0.5f, 0.5f, 0.9f});  // a third level below the first octant only
  tree.bound.push_back({0.5f, 0.5f, 0.5f, 2});
  tree.first_child[1] = 9, tree.child_count[1] = 1, tree.bound_index[1] = 1;
  tree.first_child.push_back(0), tree.child_count.push_back(0), tree.bound_index.push_back(kNone);
  tree.level_begin = {0, 1, 9, 10};
  tree.statistics.resize(3);
  const Evaluation e = evaluate(kCube, tree, {.limits = false});
  EXPECT_EQ(e.levels[2].spheres, 8u);
  EXPECT_EQ(e.hierarchy.leaves, 8u);
  EXPECT_GT(e.levels[2].coverage.uncovered_fraction, 0.05) << "the child stands in another octant than its parent";
}

TEST(EvaluateTree, OriginMovesTheTree) {
  SphereTree tree = octantTree(0.9f, 1.8f);
  const Evaluation here = evaluate(kCube, tree);
  tree.origin_mm = {64, -128, 256};
  TriangleMesh mesh = kCube;
  for (Vector3d& p : mesh.positions) p += Vector3d(64, -128, 256);
  const Evaluation there = evaluate(mesh, tree);
  for (std::size_t l = 0; l < 2; ++l) {
    EXPECT_NEAR(here.levels[l].overhang.max, there.levels[l].overhang.max, 1e-6);
    EXPECT_NEAR(here.levels[l].excess_volume_fraction, there.levels[l].excess_volume_fraction, 1e-6);
  }
  EXPECT_EQ(there.levels[1].coverage.uncovered_fraction, 0);
}

TEST(EvaluateTree, AnyNumberOfThreadsGivesTheSameBits) {
  const TriangleMesh torus = test::torusMesh(1.2, 0.5, 30, 14);
  const std::string one = figures(evaluate(torus, octantTree(0.8f, 1.8f), {.threads = 1}));
  for (const int threads : {4, 0}) EXPECT_EQ(figures(evaluate(torus, octantTree(0.8f, 1.8f), {.threads = threads})), one) << threads;
  EXPECT_NE(figures(evaluate(torus, octantTree(0.8f, 1.8f), {.seed = 2})), one);
}

TEST(EvaluateTree, CancelsAndRefusesAnEmptyTree) {
  Progress progress;
  EXPECT_THROW(evaluateTree(kCube, SphereTree{}, {}, progress), std::invalid_argument);
  progress.cancel();
  EXPECT_THROW(evaluateTree(kCube, octantTree(0.9f, 1.8f), {}, progress), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
