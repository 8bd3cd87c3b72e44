// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree/assemble_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "support/random_levels.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::Levels;
using test::randomLevels;

TEST(AssembleTree, NodesMayEndEarlyAndStandBehindTheirInnerSiblings) {
  const Levels levels = randomLevels({1, 3, 2}, 4);
  const SphereTree tree = assembleTree(levels, {{}, {0, 0, 0}, {2, 2}}, 3);  // only sphere 2 has children
  EXPECT_EQ(findFault(tree), "");
  EXPECT_EQ(tree.cover[1], levels[1][2]);
  EXPECT_EQ(tree.child_count, (std::vector<std::uint8_t>{3, 2, 0, 0, 0, 0}));
  EXPECT_EQ(levelSet(tree, 2).size(), 4u) << "two leaves of level 1 stand for their part";
}

TEST(AssembleTree, AnOnlyChildThatRepeatsItsParentIsLeftOut) {
  Levels levels = randomLevels({1, 2, 3, 4}, 6);
  levels[2][0] = levels[3][0] = levels[1][0];  // a chain of one sphere
  const SphereTree tree = assembleTree(levels, {{}, {0, 0}, {0, 1, 1}, {0, 1, 1, 2}}, 3);
  EXPECT_EQ(findFault(tree), "");
  EXPECT_EQ(tree.nodeCount(), 8u) << "of 10";
  EXPECT_EQ(std::count(tree.cover.begin(), tree.cover.end(), levels[1][0]), 1);
  EXPECT_EQ(levelSet(tree, 3).size(), 4u);
}

TEST(AssembleTree, RefusesParentsThatMakeNoTree) {
  const Levels levels = randomLevels({1, 2, 3}, 1);
  EXPECT_THROW(assembleTree({}, {}, 4), std::invalid_argument);
  EXPECT_THROW(assembleTree(randomLevels({2, 2}, 1), {{}, {0, 1}}, 4), std::invalid_argument);
  EXPECT_THROW(assembleTree(levels, {{}, {0, 0}}, 4), std::invalid_argument) << "a level without parents";
  EXPECT_THROW(assembleTree(levels, {{}, {0, 0}, {0, 1}}, 4), std::invalid_argument) << "a sphere without a parent";
  EXPECT_THROW(assembleTree(levels, {{}, {0, 0}, {0, 1, 2}}, 4), std::invalid_argument) << "a parent out of range";
  EXPECT_THROW(assembleTree(levels, {{}, {0, 0}, {0, 0, 0}}, 2), std::invalid_argument) << "too many children";
}

// Against the definition: the farthest of many points of each sphere, with the distance to a box in closed form.
TEST(AssembleTree, StatesAnOverhangThatNoPointOfTheLevelExceeds) {
  const Vector3d low(1e5, -3, -1), high = low + Vector3d(6, 6, 2);
  const DistanceField field(test::boxMesh(low, high));
  Levels levels = randomLevels({1, 3, 9}, 8);
  SphereTree tree = assembleTree(levels, {{}, {0, 0, 0}, {0, 0, 0, 1, 1, 1, 2, 2, 2}}, 4);
  tree.origin_mm = {low.x() + 3, 0, 0};
  const std::vector<double> stated = stateOverhang(field, tree);
  ASSERT_EQ(stated.size(), 3u);
  const Vector3d origin(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]);
  test::Random random(2);
  for (int level = 0; level < 3; ++level) {
    double farthest = -1e9;
    for (const std::uint32_t node : levelSet(tree, level)) {
      const Sphere& s = tree.cover[node];
      for (int i = 0; i < 4000; ++i)
        farthest = std::max(farthest, test::boxDistance(low, high, Vector3d(s.x, s.y, s.z) + origin + s.radius * random.direction()));
    }
    const auto l = static_cast<std::size_t>(level);
    EXPECT_LE(farthest, stated[l]);
    EXPECT_LE(stated[l], static_cast<double>(tree.statistics[l].overhang_bound)) << "rounded up";
    EXPECT_LE(static_cast<double>(tree.statistics[l].overhang_bound), stated[l] * (1 + 1e-6)) << "and no farther than a float needs";
  }
}

}  // namespace
}  // namespace spheretree::builder
