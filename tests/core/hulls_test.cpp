// SPDX-License-Identifier: Apache-2.0
#include "spheretree/core/hulls.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "spheretree/core/sphere_tree_codec.h"
#include "support/sample_hulls.h"
#include "support/sample_trees.h"

namespace spheretree {
namespace {

SphereTree withHulls(const Hulls& hulls) {
  SphereTree tree = test::threeLevelTree();
  tree.hulls = hulls;
  return tree;
}

TEST(Hulls, FilesReturnThemBitForBit) {
  for (const Hulls& hulls : {test::discHulls(2, 0.5, 22), test::rodHulls({0, 0, 0}, 1.5, {0, 0, 100}, 0.25), test::ballHull(3)}) {
    ASSERT_EQ(findFault(hulls), "");
    SphereTree again;
    std::string fault;
    ASSERT_EQ(decodeSphereTree(encodeSphereTree(withHulls(hulls)), again, &fault), LoadStatus::Ok) << fault;
    EXPECT_EQ(again.hulls, hulls);
  }
}

TEST(Hulls, SteepnessIsThatOfTheClosedForms) {
  Hulls hulls;
  hulls.balls = {{0, 0, 0, 1}, {4, 0, 0, 3}, {0, 4, 0, 1}, {8, 0, 0, 5}};
  EXPECT_DOUBLE_EQ(steepness(hulls, {0, 1, kNoHullBall}), 0.5);
  EXPECT_DOUBLE_EQ(steepness(hulls, {0, 1, 2}), 0.5);
  EXPECT_DOUBLE_EQ(steepness(hulls, {1, 2, 0}), 0.5);
  EXPECT_GT(steepness(hulls, {0, 1, 3}), 1e9) << "the centres lie on a line";
}

TEST(Hulls, EveryBrokenRuleIsNamed) {
  const Hulls sound = test::discHulls(2, 0.5, 6);
  struct Case {
    const char* sentence;
    std::function<void(Hulls&)> break_it;
  };
  const Case cases[] = {
      {"bound of the overhang", [](Hulls& h) { h.overhang_bound = -1; }},
      {"ball 2 is not finite", [](Hulls& h) { h.balls[2].radius = 0; }},
      {"order of their numbers", [](Hulls& h) { std::swap(h.parts.front(), h.parts.back()); }},
      {"part 17: it has a ball that there is not", [](Hulls& h) { h.parts[17][2] = 7; }},
      {"part 7: it has the same ball twice",
       [](Hulls& h) {
         h.parts[7] = {3, 3, kNoHullBall};
       }},
      {"part 0: it has a ball that there is not",
       [](Hulls& h) {
         h.parts[0] = {0, kNoHullBall, 1};
       }},
      {"almost holds another", [](Hulls& h) { h.balls[0].radius = 3; }},
      {"does not enclose", [](Hulls& h) { h.search.inner[0].radius *= 0.5f; }},
      {"holds 18 of 17 items", [](Hulls& h) { h.parts.pop_back(); }},
  };
  for (const Case& c : cases) {
    Hulls hulls = sound;
    c.break_it(hulls);
    EXPECT_NE(findFault(hulls).find(c.sentence), std::string::npos) << c.sentence << ": " << findFault(hulls);
    EXPECT_THROW(encodeSphereTree(withHulls(hulls)), std::invalid_argument) << c.sentence;
  }
}

}  // namespace
}  // namespace spheretree
