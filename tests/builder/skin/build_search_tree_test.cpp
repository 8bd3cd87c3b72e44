// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/build_search_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "spheretree/core/sphere_tree.h"
#include "support/random.h"
#include "support/sample_skins.h"

namespace spheretree::builder {
namespace {

std::vector<Sphere> cloud(std::size_t count, std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Sphere> spheres;
  for (std::size_t i = 0; i < count; ++i) {
    const Eigen::Vector3d p = 10 * random.direction();
    spheres.push_back(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), static_cast<float>(random.between(0.01, 0.5))});
  }
  return spheres;
}

/// Returns true if each inner sphere encloses each sphere of each item below, by the rule of the tree's findFault().
bool enclosesAll(const SearchTree& tree, const std::vector<Sphere>& spheres, std::size_t spheres_of_item) {
  std::vector<std::size_t> parent(tree.inner.size(), 0);
  std::size_t next = 1, taken = 0;
  for (std::size_t i = 0; i < tree.inner.size(); ++i) {
    for (std::size_t k = 0; k < tree.inner_children[i]; ++k) parent[next++] = i;
    for (std::size_t k = 0; k < tree.item_children[i]; ++k, ++taken)
      for (std::size_t above = i;; above = parent[above]) {
        const Sphere& s = tree.inner[above];
        for (std::size_t j = 0; j < spheres_of_item; ++j) {
          const Sphere& o = spheres[tree.item[taken] * spheres_of_item + j];
          const double dx = double{s.x} - double{o.x}, dy = double{s.y} - double{o.y}, dz = double{s.z} - double{o.z};
          if (!(std::sqrt(dx * dx + dy * dy + dz * dz) + double{o.radius} <= double{s.radius})) return false;
        }
        if (above == 0) break;
      }
  }
  return true;
}

TEST(BuildSearchTree, EnclosesEveryItemAndTakesEachOnce) {
  for (const std::size_t count : {1u, 2u, 7u, 8u, 9u, 64u, 500u, 2000u}) {
    const std::vector<Sphere> spheres = cloud(count, count);
    const SearchTree tree = buildSearchTree(spheres);
    EXPECT_EQ(findTopologyFault(tree, count), "") << count;
    EXPECT_TRUE(enclosesAll(tree, spheres, 1)) << count;
  }
}

TEST(BuildSearchTree, EnclosesItemsOfSeveralSpheres) {
  const std::vector<Sphere> spheres = cloud(900, 3);
  const SearchTree tree = buildSearchTree(spheres, 3);
  EXPECT_EQ(findTopologyFault(tree, 300), "");
  EXPECT_TRUE(enclosesAll(tree, spheres, 3));
}

TEST(BuildSearchTree, TakesEqualAndExtremeSpheres) {
  const std::vector<Sphere> equal(100, Sphere{1, 2, 3, 0.5f});
  std::vector<Sphere> growing;
  for (int i = 0; i < 100; ++i) growing.push_back({std::ldexp(1.0f, i - 50), 0, 0, std::ldexp(1.0f, i - 55)});
  for (const std::vector<Sphere>& spheres : {equal, growing}) {
    const SearchTree tree = buildSearchTree(spheres);
    EXPECT_EQ(findTopologyFault(tree, spheres.size()), "");
    EXPECT_TRUE(enclosesAll(tree, spheres, 1));
  }
}

TEST(BuildSearchTree, NamesAllNodesOfTheMostItems) {
  const std::vector<Sphere> spheres = cloud(kMaxSearchItems, 9);
  const SearchTree tree = buildSearchTree(spheres);
  EXPECT_EQ(findTopologyFault(tree, spheres.size()), "");  // at most 8191 inner nodes
}

TEST(BuildSearchTree, CostsASearchLessThanATreeByHalving) {
  // Nodes that small balls near the surface overlap.
  const auto cost = [](const SearchTree& tree, const std::vector<Sphere>& probes) {
    std::size_t tests = 0;
    std::vector<std::size_t> first(tree.inner.size());
    for (std::size_t i = 0, next = 1; i < tree.inner.size(); next += tree.inner_children[i++]) first[i] = next;
    for (const Sphere& p : probes) {
      std::vector<std::size_t> open{0};
      while (!open.empty()) {
        const std::size_t i = open.back();
        open.pop_back();
        const Sphere& s = tree.inner[i];
        if (std::hypot(s.x - p.x, s.y - p.y, s.z - p.z) > s.radius + p.radius) continue;
        tests += std::size_t{tree.inner_children[i]} + tree.item_children[i];
        for (std::size_t k = 0; k < tree.inner_children[i]; ++k) open.push_back(first[i] + k);
      }
    }
    return tests;
  };
  const std::vector<Sphere> spheres = cloud(2000, 1), probes = cloud(300, 2);
  EXPECT_LT(static_cast<double>(cost(buildSearchTree(spheres), probes)),
            0.8 * static_cast<double>(cost(test::searchTreeOf(spheres), probes)));
}

TEST(SortForSearch, LeavesASoundSkinWithTheSamePatches) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Skin skin = test::randomSkin(seed);
    Skin sorted = skin;
    sorted.search = {};
    std::reverse(sorted.triangles.begin(), sorted.triangles.end());
    sortForSearch(sorted);
    EXPECT_EQ(findFault(sorted), "");
    const auto names = [](const Skin& s) {
      std::multiset<std::array<std::uint16_t, 6>> all;
      for (const SkinTriangle& t : s.triangles) all.insert({t.vertex[0], t.vertex[1], t.vertex[2], t.edge[0], t.edge[1], t.edge[2]});
      return all;
    };
    EXPECT_EQ(names(sorted), names(skin));
  }
}

}  // namespace
}  // namespace spheretree::builder
