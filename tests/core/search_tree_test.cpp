// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/search_tree.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "support/sample_skins.h"

namespace spheretree {
namespace {

/// Nodes 0 .. n - 1 with these counts of children; the spheres are not used.
SearchTree counts(std::vector<std::uint8_t> inner_children, std::vector<std::uint8_t> item_children) {
  SearchTree tree;
  tree.inner.assign(inner_children.size(), Sphere{0, 0, 0, 1});
  tree.inner_children = std::move(inner_children);
  tree.item_children = std::move(item_children);
  return tree;
}

/// Returns true if the counts make one tree over `items` items, by a breadth-first walk with a queue.
bool isOneTree(const SearchTree& tree, std::size_t items) {
  std::size_t queued = 1, taken = 0;
  for (std::size_t i = 0; i < tree.inner.size(); ++i) {
    if (i >= queued) return false;  // no node leads to this one
    const int children = tree.inner_children[i] + tree.item_children[i];
    if (children < 1 || children > 8) return false;
    queued += tree.inner_children[i];
    taken += tree.item_children[i];
  }
  return queued == tree.inner.size() && taken == items;
}

TEST(SearchTree, TopologyIsAcceptedExactlyIfAQueueWalksIt) {
  int accepted = 0;
  constexpr int kChoices = 4 * 3;  // 0 to 3 inner children, 0 to 2 items
  for (int code = 0; code < kChoices * kChoices * kChoices * kChoices; ++code) {
    std::vector<std::uint8_t> inner, item;
    for (int digits = code, i = 0; i < 4; ++i, digits /= kChoices) {
      inner.push_back(static_cast<std::uint8_t>(digits % kChoices % 4));
      item.push_back(static_cast<std::uint8_t>(digits % kChoices / 4));
    }
    const SearchTree tree = counts(inner, item);
    for (std::size_t items = 0; items <= 9; ++items) {
      const bool sound = isOneTree(tree, items);
      ASSERT_EQ(findTopologyFault(tree, items).empty(), sound) << "code " << code << ", " << items << " items";
      accepted += sound;
    }
  }
  EXPECT_GT(accepted, 100);
}

TEST(SearchTree, TreesByHalvingAreSoundAndHoldEachItemBelowTheRootOnce) {
  for (const std::size_t items : {1, 2, 7, 8, 9, 64, 65, 511, 1000})
    for (const std::size_t branching : {2, 5, 8}) {
      std::vector<Sphere> spheres;
      test::Random random(items);
      for (std::size_t i = 0; i < items; ++i)
        spheres.push_back({static_cast<float>(random.below(1000)), static_cast<float>(random.below(1000)), 0, 1});
      const SearchTree tree = test::searchTreeOf(spheres, branching);
      EXPECT_EQ(findTopologyFault(tree, items), "");
      EXPECT_NE(findTopologyFault(tree, items + 1), "");
      std::vector<int> met(items, 0);
      for (const std::uint16_t item : tree.item) ++met[item];
      EXPECT_EQ(met, std::vector<int>(items, 1));
    }
}

TEST(SearchTree, EachBrokenRuleIsNamed) {
  const SearchTree sound = [] {
    SearchTree tree = counts({2, 0, 1, 0}, {1, 2, 0, 3});
    tree.item = {5, 3, 1, 0, 2, 4};
    return tree;
  }();
  ASSERT_EQ(findTopologyFault(sound, 6), "");
  struct Case {
    const char* words;
    std::function<void(SearchTree&)> damage;
  };
  const std::vector<Case> cases{
      {"no root", [](SearchTree& t) { t = SearchTree(); }},
      {"other numbers of child counts", [](SearchTree& t) { t.inner_children.pop_back(); }},
      {"other numbers of child counts", [](SearchTree& t) { t.item_children.push_back(1); }},
      {"node 3 of the search tree has 0 children", [](SearchTree& t) { t.item_children[3] = 0; }},
      {"node 1 of the search tree has 9 children", [](SearchTree& t) { t.item_children[1] = 9; }},
      {"node 0 of the search tree has 256 children", [](SearchTree& t) { t.inner_children[0] = 255; }},
      {"do not make one tree", [](SearchTree& t) { t.inner_children[0] = 4; }},
      {"do not make one tree",
       [](SearchTree& t) {
         t.inner_children.assign({0, 2, 1, 0});
       }},
      {"do not make one tree",
       [](SearchTree& t) {
         t.inner_children.assign({2, 0, 0, 1}), t.item_children[2] = 1;
       }},
      {"holds 7 of 6 items", [](SearchTree& t) { ++t.item_children[1]; }},
      {"holds 5 of 6 items", [](SearchTree& t) { --t.item_children[1]; }},
      {"orders 5 of 6 items", [](SearchTree& t) { t.item.pop_back(); }},
      {"item 6 of the search tree is out of range", [](SearchTree& t) { t.item[2] = 6; }},
      {"item 3 of the search tree is out of range or taken twice", [](SearchTree& t) { t.item[4] = 3; }},
      {"at most 8191", [](SearchTree& t) { t.inner.resize(kMaxSearchNodes + 1); }},
  };
  for (const Case& c : cases) {
    SearchTree tree = sound;
    c.damage(tree);
    EXPECT_NE(findTopologyFault(tree, 6).find(c.words), std::string::npos) << c.words << "\nfound: " << findTopologyFault(tree, 6);
  }
  EXPECT_NE(findTopologyFault(sound, kMaxSearchItems + 1).find("at most"), std::string::npos);
}

TEST(SearchTree, HasAtMost256Levels) {
  for (const std::size_t levels : {kMaxSearchLevels, kMaxSearchLevels + 1}) {  // a chain: each node has one inner child and one item
    SearchTree tree = counts(std::vector<std::uint8_t>(levels, 1), std::vector<std::uint8_t>(levels, 1));
    tree.inner_children.back() = 0;
    EXPECT_EQ(findTopologyFault(tree, levels), levels == kMaxSearchLevels ? "" : "the search tree has more than 256 levels");
  }
}

}  // namespace
}  // namespace spheretree
