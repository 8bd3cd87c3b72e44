// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/sphere_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "spheretree/core/smallest_enclosing_ball.h"
#include "support/sample_skins.h"

namespace spheretree {
namespace {

double reach(const Sphere& from, const Sphere& to) {
  return std::hypot(double{to.x} - from.x, double{to.y} - from.y, double{to.z} - from.z) + to.radius;
}

/// Nodes below `node`, itself included, by following the children one by one.
std::vector<std::uint32_t> family(const SphereTree& tree, std::uint32_t node) {
  std::vector<std::uint32_t> nodes{node};
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (std::uint32_t c = 0; c < tree.child_count[nodes[i]]; ++c) nodes.push_back(tree.first_child[nodes[i]] + c);
  return nodes;
}

TEST(LinkNodes, FindsChildrenAndLevels) {
  SphereTree tree;
  tree.child_count = {3, 2, 1, 0, 0, 0, 0};
  tree.cover.resize(7);
  ASSERT_TRUE(linkNodes(tree));
  EXPECT_EQ(tree.first_child, (std::vector<std::uint32_t>{1, 4, 6, 0, 0, 0, 0}));
  EXPECT_EQ(tree.bound_index, (std::vector<std::uint32_t>{0, 1, 2, kNone, kNone, kNone, kNone}));
  EXPECT_EQ(tree.level_begin, (std::vector<std::uint32_t>{0, 1, 4, 7}));
  EXPECT_EQ(levelSet(tree, 0), (std::vector<std::uint32_t>{0}));
  EXPECT_EQ(levelSet(tree, 1), (std::vector<std::uint32_t>{1, 2, 3}));
  EXPECT_EQ(levelSet(tree, 2), (std::vector<std::uint32_t>{3, 4, 5, 6})) << "the leaf of level 1 stands for its part";
}

TEST(LinkNodes, RefusesWhatIsNotOneTree) {
  const auto links = [](std::vector<std::uint8_t> counts) {
    SphereTree tree;
    tree.cover.resize(counts.size());
    tree.child_count = std::move(counts);
    return linkNodes(tree);
  };
  EXPECT_TRUE(links({0}));
  EXPECT_TRUE(links({1, 1, 1, 1, 1, 0}));
  EXPECT_FALSE(links({})) << "no root";
  EXPECT_FALSE(links({0, 0})) << "two roots";
  EXPECT_FALSE(links({1, 1, 1, 1, 1, 1, 0})) << "seven levels";
  EXPECT_FALSE(links({2, 0, 1, 0})) << "a leaf ahead of its inner sibling";
  EXPECT_FALSE(links({3, 0, 0})) << "children past the end";
  EXPECT_FALSE(links({2, 0, 0, 1, 0})) << "a node with no parent";
  EXPECT_FALSE(links({255})) << "a count that no array holds";
  EXPECT_FALSE(links(std::vector<std::uint8_t>(kMaxNodes + 1, 0)));
}

TEST(EncloseDescendants, EnclosesEachNodeWithAllItsDescendants) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SphereTree tree = test::randomTree(seed, 4, 8);
    for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
      if (tree.isLeaf(i)) continue;
      std::vector<Sphere> spheres;
      for (const std::uint32_t k : family(tree, i)) spheres.push_back(tree.cover[k]);
      EXPECT_EQ(tree.bound[tree.bound_index[i]], smallestEnclosing(spheres)) << "seed " << seed << ", node " << i;
    }
  }
}

TEST(FindFault, AcceptsRandomTreesWhoseEnclosureHoldsOneByOne) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SphereTree tree = test::randomTree(seed, 1 + static_cast<int>(seed % 6), 2 + static_cast<int>(seed % 7));
    EXPECT_EQ(findFault(tree), "") << "seed " << seed;
    for (std::uint32_t i = 0; i < tree.nodeCount(); ++i) {
      if (tree.isLeaf(i)) continue;
      const Sphere& bound = tree.bound[tree.bound_index[i]];
      for (const std::uint32_t k : family(tree, i)) EXPECT_LE(reach(bound, tree.cover[k]), bound.radius * (1 + 1e-15));
    }
  }
}

TEST(FindFault, FindsEachBrokenRule) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  struct Case {
    const char* words;  // must stand in the sentence
    std::function<void(SphereTree&)> damage;
  };
  const std::vector<Case> cases{
      {"no nodes", [](SphereTree& t) { t = SphereTree(); }},
      {"branching 1", [](SphereTree& t) { t.branching = 1; }},
      {"branching 9", [](SphereTree& t) { t.branching = 9; }},
      {"more than the branching", [](SphereTree& t) { t.branching = 2; }},
      {"differ in length", [](SphereTree& t) { t.first_child.pop_back(); }},
      {"make one tree", [](SphereTree& t) { t.child_count[5] = 1; }},
      {"node 1: first child 5", [](SphereTree& t) { t.first_child[1] = 5; }},
      {"node 1: bounding sphere 0", [](SphereTree& t) { t.bound_index[1] = 0; }},
      {"level boundaries", [](SphereTree& t) { t.level_begin[1] = 2; }},
      {"1 bounding spheres for 2", [](SphereTree& t) { t.bound.pop_back(); }},
      {"node 4: centre", [=](SphereTree& t) { t.cover[4].y = nan; }},
      {"node 4: radius", [=](SphereTree& t) { t.cover[4].radius = inf; }},
      {"node 4: radius 0", [](SphereTree& t) { t.cover[4].radius = 0; }},
      {"node 4: radius -1", [](SphereTree& t) { t.cover[4].radius = -1; }},
      {"node 1, bounding sphere: centre", [=](SphereTree& t) { t.bound[1].z = -inf; }},
      {"node 1, bounding sphere: radius", [=](SphereTree& t) { t.bound[1].radius = nan; }},
      {"does not enclose the cover sphere of node", [](SphereTree& t) { t.bound[0].radius = std::nextafter(t.bound[0].radius, 0.0f); }},
      {"does not enclose the cover sphere of node 1,", [](SphereTree& t) { t.cover[1].radius = 100, countLevels(t); }},
      {"3 levels of nodes", [](SphereTree& t) { t.statistics.pop_back(); }},
      {"statistics of level 2: 3 spheres", [](SphereTree& t) { t.statistics[2].sphere_count = 3; }},
      {"statistics of level 2: radii", [](SphereTree& t) { t.statistics[2].largest_radius *= 2; }},
      {"overhang bound -2", [](SphereTree& t) { t.statistics[1].overhang_bound = -2; }},
      {"overhang bound", [=](SphereTree& t) { t.statistics[1].overhang_bound = nan; }},
      {"origin", [](SphereTree& t) { t.origin_mm[2] = std::numeric_limits<double>::infinity(); }},
      {"unit 0 mm", [](SphereTree& t) { t.provenance.unit_mm = 0; }},
      {"overhang at work", [](SphereTree& t) { t.provenance.work_overhang_mm = -1; }},
      {"volume -1", [](SphereTree& t) { t.provenance.volume_mm3 = -1; }},
      {"builder", [](SphereTree& t) { t.provenance.builder = "sixteen letters!"; }},
      {"generator", [](SphereTree& t) { t.provenance.generator = std::string("a\0b", 3); }},
      {"search over the leaves: there is an order of leaves", [](SphereTree& t) { t.search.inner.clear(); }},
      {"search over the leaves: the search tree holds 4 of 3 items",
       [](SphereTree& t) {
         t = test::withSearch(test::treeOf({3, 0, 0, 0})), ++t.search.item_children[0];
       }},
      {"search over the leaves: sphere 0 of the search tree is not finite", [=](SphereTree& t) { t.search.inner[0].x = nan; }},
      {"search over the leaves: sphere 0 of the search tree does not enclose item",
       [](SphereTree& t) { t.search.inner[0].radius *= 0.9f; }},
      {"the skin has no triangles, but something else", [](SphereTree& t) { t.skin.triangles.clear(); }},
      {"the skin has no triangles, but something else", [](SphereTree& t) { t.skin = Skin(), t.skin.tolerance = 1; }},
      {"edge 2 of the skin", [](SphereTree& t) { t.skin.edges[2].is_sharp = 2; }},
  };
  const SphereTree sound = test::withSkin(test::withSearch(test::threeLevelTree()), test::roundSkin(1));
  ASSERT_EQ(findFault(sound), "");
  for (const Case& c : cases) {
    SphereTree tree = sound;
    c.damage(tree);
    EXPECT_NE(findFault(tree).find(c.words), std::string::npos) << "expected: " << c.words << "\nfound: " << findFault(tree);
  }
}

/// The expected result of findFault() for a search tree, leaf by leaf.
bool enclosesEachLeaf(const SphereTree& tree) {
  const SearchTree& search = tree.search;
  const std::vector<Sphere> leaves = test::leavesOf(tree);
  std::vector<std::size_t> parent(search.inner.size(), 0);
  std::size_t next = 1, taken = 0;
  bool all = true;
  for (std::size_t i = 0; i < search.inner.size(); ++i) {
    for (std::size_t k = 0; k < search.inner_children[i]; ++k) parent[next++] = i;
    for (std::size_t k = 0; k < search.item_children[i]; ++k, ++taken) {
      const Sphere& leaf = leaves[search.item.empty() ? taken : search.item[taken]];
      for (std::size_t above = i;; above = parent[above]) {
        all = all && reach(search.inner[above], leaf) <= search.inner[above].radius;
        if (above == 0) break;
      }
    }
  }
  return all;
}

TEST(FindFault, FindsASphereOfTheSearchTreeThatMissesALeafExactlyIfThereIsOne) {
  test::Random random(8);
  const auto unit = [&] { return static_cast<float>(random.unit()); };
  int sound = 0, faulty = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SphereTree tree = test::withSearch(test::randomTree(seed, 4, 6), 2 + seed % 7);
    if (tree.search.inner.size() < 3) continue;
    ASSERT_EQ(findFault(tree), "");
    Sphere& sphere = tree.search.inner[random.below(tree.search.inner.size())];
    sphere.x += sphere.radius * (0.2f * unit() - 0.1f);
    sphere.radius *= 0.95f + 0.15f * unit();
    const bool encloses = enclosesEachLeaf(tree);
    EXPECT_EQ(findFault(tree).empty(), encloses) << findFault(tree);
    (encloses ? sound : faulty) += 1;
  }
  EXPECT_GT(sound, 20);
  EXPECT_GT(faulty, 20);
}

TEST(FindFault, AcceptsTheDeepestSearchTree) {
  // A chain of nodes above a tree over the largest number of leaves, none of whose spheres encloses the next: as many
  // checks as the limit of levels allows.
  std::vector<std::uint8_t> counts(4681, 8);
  counts.resize(37449, 0);
  SphereTree tree;
  tree.cover.assign(counts.size(), Sphere{0, 0, 0, 1});
  tree.child_count = counts;
  ASSERT_TRUE(linkNodes(tree));
  encloseDescendants(tree);
  countLevels(tree);
  const SearchTree plain = test::searchTreeOf(test::leavesOf(tree));
  const auto below = [&](std::size_t levels) {
    SearchTree& chain = tree.search;
    chain = SearchTree();
    for (std::size_t i = 0; i < levels; ++i) {
      chain.inner.push_back({0, 0, 0, static_cast<float>(1 + 1e-3 * static_cast<double>(i))});
      chain.inner_children.push_back(1);
      chain.item_children.push_back(0);
    }
    for (std::size_t i = 0; i < plain.inner.size(); ++i) {
      chain.inner.push_back({0, 0, 0, 2});
      chain.inner_children.push_back(plain.inner_children[i]);
      chain.item_children.push_back(plain.item_children[i]);
    }
    chain.item = plain.item;
    return findFault(tree);
  };
  EXPECT_EQ(below(kMaxSearchLevels - 5), "");
  EXPECT_NE(below(kMaxSearchLevels - 4).find("more than 256 levels"), std::string::npos);
}

TEST(CountLevels, KeepsOverhangBounds) {
  SphereTree tree = test::threeLevelTree();
  const std::vector<LevelStatistics> before = tree.statistics;
  countLevels(tree);
  EXPECT_EQ(tree.statistics, before);
  tree.statistics.clear();
  countLevels(tree);
  EXPECT_EQ(tree.statistics[1].overhang_bound, kUnproven);
  EXPECT_EQ(tree.statistics[2].sphere_count, 4u);
}

}  // namespace
}  // namespace spheretree
