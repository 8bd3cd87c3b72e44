// SPDX-License-Identifier: GPL-3.0-or-later
#include "tree/hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <tuple>

#include "base/ball.h"
#include "support/random_levels.h"
#include "tree/assemble_tree.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::Levels;
using test::randomLevels;
using test::sphere;
using Parents = std::vector<std::vector<std::uint32_t>>;

Vector3d centre(const Sphere& s) { return {s.x, s.y, s.z}; }

// The cost that grouping minimises: number of children times the cube root of the bounding radius, over the inner
// nodes.
double traversalCost(const SphereTree& tree) {
  double sum = 0;
  for (std::size_t i = 0; i < tree.nodeCount(); ++i)
    if (!tree.isLeaf(i)) sum += tree.child_count[i] * std::cbrt(static_cast<double>(tree.bound[tree.bound_index[i]].radius));
  return sum;
}

// Number of spheres that a ball of radius 0 tests at every leaf's centre: the quantity that the cost estimates.
double nodesTested(const SphereTree& tree) {
  std::size_t tested = 0;
  for (const std::uint32_t leaf : levelSet(tree, tree.levelCount() - 1)) {
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
      const std::uint32_t node = open.back();
      open.pop_back();
      ++tested;
      const Sphere& s = sphereOf(tree, node, SphereKind::Bound);
      if ((centre(s) - centre(tree.cover[leaf])).norm() > static_cast<double>(s.radius)) continue;
      for (std::uint32_t c = 0; c < tree.child_count[node]; ++c) open.push_back(tree.first_child[node] + c);
    }
  }
  return static_cast<double>(tested);
}

// The obvious method: every child goes to the nearest parent with a free place, in the given order.
Parents nearestFirst(const Levels& levels, std::size_t capacity) {
  Parents parents(levels.size());
  for (std::size_t level = 1; level < levels.size(); ++level) {
    std::vector<std::size_t> members(levels[level - 1].size(), 0);
    for (const Sphere& s : levels[level]) {
      std::uint32_t best = 0;
      double smallest = std::numeric_limits<double>::infinity();
      for (std::uint32_t p = 0; p < members.size(); ++p) {
        const double distance = (centre(s) - centre(levels[level - 1][p])).norm();
        if (members[p] < capacity && distance < smallest) smallest = distance, best = p;
      }
      ++members[best];
      parents[level].push_back(best);
    }
  }
  return parents;
}

TEST(Hierarchy, CountsOfTheShallowestTree) {
  EXPECT_EQ(levelCounts(1, 8), (std::vector<std::size_t>{1}));
  EXPECT_EQ(levelCounts(8, 8), (std::vector<std::size_t>{1, 8}));
  EXPECT_EQ(levelCounts(60, 8), (std::vector<std::size_t>{1, 8, 60}));
  EXPECT_EQ(levelCounts(100, 8), (std::vector<std::size_t>{1, 3, 17, 100}));
  EXPECT_EQ(levelCounts(512, 8), (std::vector<std::size_t>{1, 8, 64, 512}));
  for (const int branching : {2, 3, 5, 8})
    for (std::size_t leaves = 1; leaves < 300; ++leaves) {
      const std::vector<std::size_t> counts = levelCounts(leaves, branching);
      ASSERT_EQ(counts.front(), 1u);
      ASSERT_EQ(counts.back(), leaves);
      std::size_t largest = 1;
      for (std::size_t level = 1; level < counts.size(); ++level) {
        ASSERT_LE(counts[level - 1], counts[level]);
        ASSERT_LE(counts[level], counts[level - 1] * static_cast<std::size_t>(branching));
        if (level + 1 < counts.size()) largest *= static_cast<std::size_t>(branching);
      }
      ASSERT_TRUE(leaves == 1 || largest < leaves) << "a level less would do";
    }
}

TEST(Hierarchy, KeepsTheCapacityAndLeavesNoParentEmpty) {
  const std::vector<std::tuple<int, std::vector<std::size_t>>> cases{{2, {1, 2, 4, 8}},    {3, {1, 2, 5, 15}}, {4, {1, 4, 13, 40, 100}},
                                                                     {8, {1, 8, 64, 512}}, {8, {1, 7, 7, 8}},  {5, {1, 1, 1}}};
  for (const auto& [branching, sizes] : cases) {
    Levels levels = randomLevels(sizes, 1);
    const Parents parents = groupLevels(levels, branching);
    ASSERT_EQ(parents.size(), levels.size());
    EXPECT_TRUE(parents[0].empty());
    for (std::size_t level = 1; level < levels.size(); ++level) {
      ASSERT_EQ(parents[level].size(), levels[level].size());
      std::vector<int> members(levels[level - 1].size(), 0);
      for (const std::uint32_t p : parents[level]) ++members.at(p);
      EXPECT_LE(*std::max_element(members.begin(), members.end()), branching);
      EXPECT_GE(*std::min_element(members.begin(), members.end()), 1);
    }
    const SphereTree tree = assembleTree(levels, parents, branching);
    EXPECT_EQ(findFault(tree), "") << "bounding spheres enclose, breadth first, consecutive";
    for (std::size_t level = 0; level < levels.size(); ++level) {
      // The same spheres on the same level, in any order.
      std::vector<Sphere> stored(tree.cover.begin() + tree.level_begin[level], tree.cover.begin() + tree.level_begin[level + 1]),
          given = levels[level];
      const auto less = [](const Sphere& a, const Sphere& b) {
        return std::tie(a.x, a.y, a.z, a.radius) < std::tie(b.x, b.y, b.z, b.radius);
      };
      std::sort(stored.begin(), stored.end(), less);
      std::sort(given.begin(), given.end(), less);
      EXPECT_EQ(stored, given);
    }
  }
}

TEST(Hierarchy, GroupsTighterThanNearestFirst) {
  double ours = 0, plain = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Levels levels = randomLevels({1, 8, 60, 300}, seed);
    const double b = nodesTested(assembleTree(levels, nearestFirst(levels, 8), 8));
    const double a = nodesTested(assembleTree(levels, groupLevels(levels, 8), 8));
    EXPECT_LT(a, b) << "seed " << seed;
    ours += a;
    plain += b;
  }
  EXPECT_LT(ours, 0.9 * plain);
}

// Parents whose own spheres are no guide: moves and swaps alone must find the two clusters.
TEST(Hierarchy, FindsClustersThatTheParentsDoNotShow) {
  Levels levels{{sphere({0, 0, 0}, 30)}, {sphere({0, 0, 0}, 0.1), sphere({0, 0, 0}, 0.1)}, {}};
  test::Random random(3);
  for (int i = 0; i < 8; ++i) levels[2].push_back(sphere(Vector3d(i % 2 ? 10 : -10, 0, 0) + random.inCube(1), 0.5));
  const Parents parents = groupLevels(levels, 4);
  for (std::size_t i = 2; i < 8; ++i) EXPECT_EQ(parents[2][i], parents[2][i % 2]) << i;
  EXPECT_NE(parents[2][0], parents[2][1]);
}

// Six children under two parents of three: all 20 groupings.
TEST(Hierarchy, IsNearTheBestOfAllGroupings) {
  double ours = 0, optimal = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Levels levels = randomLevels({1, 2, 6}, seed);
    const auto cost = [&](const Parents& parents) { return traversalCost(assembleTree(levels, parents, 3)); };
    double best = std::numeric_limits<double>::infinity();
    for (unsigned mask = 0; mask < 64; ++mask) {
      Parents parents{{}, {0, 0}, {}};
      for (unsigned c = 0; c < 6; ++c) parents[2].push_back(mask >> c & 1);
      if (std::count(parents[2].begin(), parents[2].end(), 1u) == 3) best = std::min(best, cost(parents));
    }
    const double found = cost(groupLevels(levels, 3));
    EXPECT_LE(found, 1.3 * best) << "seed " << seed;
    ours += found;
    optimal += best;
  }
  EXPECT_LE(ours, 1.04 * optimal);
}

// Most leaves are at a tip, where the level above has one sphere: their groups need not extend to the other spheres of
// that level.
TEST(Hierarchy, RoomMakesNodesWhereTheLeavesAre) {
  test::Random random(5);
  Levels levels{{sphere({0, 0, 0}, 30)}, {}, {}};
  for (int i = 0; i < 4; ++i) levels[1].push_back(sphere({static_cast<double>(12 * i), 0, 0}, 6.5));
  for (int i = 0; i < 24; ++i) levels[2].push_back(sphere(random.inCube(3), 0.5));
  for (int i = 1; i < 4; ++i) levels[2].push_back(sphere({static_cast<double>(12 * i), 0, 0}, 6));
  Levels with_room = levels;
  const SphereTree plain = assembleTree(levels, groupLevels(levels, 8), 8);
  const Parents parents = groupLevels(with_room, 8, SpareParents::Fill);
  const SphereTree roomy = assembleTree(with_room, parents, 8);
  EXPECT_EQ(findFault(roomy), "");
  ASSERT_EQ(with_room[1].size(), 8u);
  EXPECT_EQ(Levels({{with_room[1].begin(), with_room[1].begin() + 4}}), Levels({levels[1]})) << "those given stay ahead";
  for (std::uint32_t p = 4; p < 8; ++p) {
    bool repeats = false;
    for (std::size_t c = 0; c < parents[2].size(); ++c) repeats = repeats || (parents[2][c] == p && with_room[2][c] == with_room[1][p]);
    EXPECT_TRUE(repeats) << "sphere " << p << " stands for none of the object but repeats a child's";
  }
  EXPECT_LT(traversalCost(roomy), 0.9 * traversalCost(plain));
  EXPECT_LT(nodesTested(roomy), 0.9 * nodesTested(plain));
}

TEST(Hierarchy, ALevelTooSmallForItsChildrenGetsFurtherNodes) {
  Levels levels = randomLevels({1, 2, 9, 33}, 5);
  const auto parents = groupLevels(levels, 4);
  ASSERT_EQ(levels[1].size(), 3u);
  EXPECT_EQ(levels[2].size(), 9u);
  EXPECT_NE(std::find(levels[2].begin(), levels[2].end(), levels[1][2]), levels[2].end()) << "it repeats a child";
  EXPECT_EQ(findFault(assembleTree(levels, parents, 4)), "");
}

TEST(Hierarchy, RefusesMoreSpheresThanTheParentsMayHave) {
  Levels too_many = randomLevels({1, 2, 17}, 1);
  EXPECT_THROW(groupLevels(too_many, 4), std::invalid_argument);
  EXPECT_THROW(groupLevels(too_many, 4, SpareParents::Fill), std::invalid_argument);
}

// On lattices many groupings have the same cost.
TEST(Hierarchy, PowersOfTwoChangeNoGroup) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    test::Random random(seed);
    const double offset = random.between(0.1, 0.9);
    const auto lattice = [&](int side, float scale) {
      std::vector<Sphere> out;
      for (int i = 0; i < side * side * side; ++i) {
        const Sphere s = sphere(Vector3d(i % side, i / side % side, i / (side * side)) / side + Vector3d::Constant(offset), 0.9 / side);
        out.push_back({scale * s.x, scale * s.y, scale * s.z, scale * s.radius});
      }
      return out;
    };
    const auto groupsAt = [&](float scale) {
      Levels levels{lattice(1, scale), lattice(2, scale), lattice(4, scale), lattice(8, scale)};
      return groupLevels(levels, 8, SpareParents::Fill);
    };
    const Parents parents = groupsAt(1);
    for (const float scale : {0x1p-20f, 0x1p-1f, 0x1p1f, 0x1p2f, 0x1p7f}) EXPECT_EQ(groupsAt(scale), parents) << scale;
  }
}

}  // namespace
}  // namespace spheretree::builder
