// SPDX-License-Identifier: Apache-2.0
#include "search_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

// Over the surface of a box, larger where they are many.
std::vector<Sphere> scattered(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Sphere> leaves;
  for (std::size_t i = 0; i < count; ++i) {
    Eigen::Vector3d c(random.between(-20, 20), random.between(-5, 5), random.between(-2, 2));
    c[static_cast<Eigen::Index>(random.below(3))] = 0;
    leaves.push_back({static_cast<float>(c.x()), static_cast<float>(c.y()), static_cast<float>(c.z()),
                      static_cast<float>(random.between(0.2, 1) * std::sqrt(200 / static_cast<double>(count)))});
  }
  return leaves;
}

double reach(const Sphere& about, const Sphere& s) {
  return (Eigen::Vector3d(s.x, s.y, s.z) - Eigen::Vector3d(about.x, about.y, about.z)).norm() + static_cast<double>(s.radius);
}

// Sound, and tight: every inner sphere holds the leaves below it with nothing to spare.
void expectSound(const std::vector<SearchNode>& nodes, const std::vector<Sphere>& leaves) {
  std::vector<int> seen(leaves.size(), 0);
  std::size_t next = 1;
  for (const SearchNode& n : nodes) {
    if (n.child_count == 0) {
      ASSERT_LT(n.leaf, leaves.size());
      EXPECT_EQ(n.sphere, leaves[n.leaf]);
      ++seen[n.leaf];
      continue;
    }
    ASSERT_EQ(n.leaf, kNotALeaf);
    ASSERT_EQ(n.first_child, next);
    ASSERT_TRUE(n.child_count >= 2 && n.child_count <= 8);
    next += n.child_count;
    for (std::uint32_t k = 1; k < n.child_count; ++k)
      EXPECT_LE(nodes[n.first_child + k].child_count > 0, nodes[n.first_child + k - 1].child_count > 0) << "inner siblings stand ahead";
    double farthest = 0;
    std::function<void(const SearchNode&)> visit = [&](const SearchNode& below) {
      if (below.child_count == 0) farthest = std::max(farthest, reach(n.sphere, below.sphere));
      for (std::uint32_t k = 0; k < below.child_count; ++k) visit(nodes[below.first_child + k]);
    };
    visit(n);
    EXPECT_LE(farthest, static_cast<double>(n.sphere.radius));
    EXPECT_GE(farthest * (1 + 1e-6), static_cast<double>(n.sphere.radius));
  }
  EXPECT_EQ(next, nodes.size());
  for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i], 1) << "leaf " << i;
}

TEST(SearchTree, HoldsEveryLeafOnce) {
  for (const std::size_t count : {1, 2, 7, 8, 9, 15, 64, 65, 512, 1000}) {
    SCOPED_TRACE(count);
    const std::vector<Sphere> leaves = scattered(count, count);
    expectSound(makeSearchTree(leaves), leaves);
  }
}

TEST(SearchTree, EqualLeavesMakeATree) {
  const std::vector<Sphere> leaves(100, Sphere{1, 2, 3, 4});
  expectSound(makeSearchTree(leaves), leaves);
}

// One in the other, so that the tree of least area is a chain.
TEST(SearchTree, NestedLeavesMakeATree) {
  std::vector<Sphere> leaves;
  for (int i = 0; i < 1000; ++i) leaves.push_back({1, 2, 3, 1 + 0.01f * static_cast<float>(i)});
  expectSound(makeSearchTree(leaves), leaves);
}

// The squares of their sizes are beyond float.
TEST(SearchTree, HugeLeavesMakeATree) {
  std::vector<Sphere> leaves = scattered(1000, 3);
  for (Sphere& s : leaves) s = {s.x * 1e30f, s.y * 1e30f, s.z * 1e30f, s.radius * 1e30f};
  std::vector<int> seen(leaves.size(), 0);
  for (const SearchNode& n : makeSearchTree(leaves))
    if (n.child_count == 0) ++seen[n.leaf];
  EXPECT_EQ(seen, std::vector<int>(leaves.size(), 1));
}

// Slots are named by 16 bits: block 0 has the root, every inner node a block of 8 more.
TEST(SearchTree, TheLargestTreeHasRoomInTheNames) {
  for (const std::size_t count : {8192, 8193, 32768}) {
    const std::vector<SearchNode> nodes = makeSearchTree(scattered(count, 7));
    EXPECT_LE(nodes.size() - count, 8191u) << count;
  }
}

// Spheres that a point tests at every leaf's centre.
double tested(const std::vector<SearchNode>& nodes, const std::vector<Sphere>& leaves) {
  std::size_t sum = 0;
  for (const Sphere& leaf : leaves) {
    std::vector<std::uint32_t> open{0};
    while (!open.empty()) {
      const SearchNode& n = nodes[open.back()];
      open.pop_back();
      ++sum;
      if (reach(n.sphere, {leaf.x, leaf.y, leaf.z, 0}) > static_cast<double>(n.sphere.radius)) continue;
      for (std::uint32_t k = 0; k < n.child_count; ++k) open.push_back(n.first_child + k);
    }
  }
  return static_cast<double>(sum);
}

// What one would write first: eight neighbours along x at a time, level by level.
std::vector<SearchNode> slices(std::vector<Sphere> leaves) {
  std::sort(leaves.begin(), leaves.end(), [](const Sphere& a, const Sphere& b) { return a.x < b.x; });
  std::vector<SearchNode> nodes;
  for (std::size_t size = leaves.size(); size > 1; size /= 8)
    for (std::size_t begin = 0; begin < leaves.size(); begin += size)
      nodes.push_back({smallestEnclosing(std::span(leaves).subspan(begin, size)), kNotALeaf, 0, 8});
  for (const Sphere& s : leaves) nodes.push_back({s, 0});
  std::uint32_t next = 1;
  for (SearchNode& n : nodes)
    if (n.child_count > 0) n.first_child = next, next += 8;
  return nodes;
}

TEST(SearchTree, GroupsTighterThanSlices) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<Sphere> leaves = scattered(512, seed);
    EXPECT_LT(tested(makeSearchTree(leaves), leaves), 0.3 * tested(slices(leaves), leaves)) << seed;
  }
}

}  // namespace
}  // namespace spheretree::runtime
