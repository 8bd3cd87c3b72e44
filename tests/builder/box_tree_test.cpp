// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/box_tree.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "support/random.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using Boxes = std::vector<Eigen::AlignedBox3d>;

Boxes randomBoxes(test::Random& random, std::size_t count, double size) {
  Boxes boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d low = random.inCube(1);
    boxes.emplace_back(low, low + random.inBox(Vector3d::Zero(), Vector3d::Constant(size)));
  }
  return boxes;
}

double nearestByTree(const BoxTree& tree, const Boxes& boxes, const Vector3d& p) {
  double limit2 = std::numeric_limits<double>::infinity();
  tree.searchNearest(p, limit2, [&](std::size_t first, std::size_t count) {
    for (std::size_t s = first; s < first + count; ++s) limit2 = std::min(limit2, boxes[tree.order()[s]].squaredExteriorDistance(p));
  });
  return limit2;
}

TEST(BoxTree, NearestBoxIsTheOneOfBruteForce) {
  test::Random random(1);
  for (const std::size_t count : {1, 2, 4, 5, 17, 300, 2000})
    for (const double size : {0.0, 0.05, 1.0}) {
      const Boxes boxes = randomBoxes(random, count, size);
      const BoxTree tree(boxes);
      for (int k = 0; k < 100; ++k) {
        const Vector3d p = random.inCube(2);
        double best = std::numeric_limits<double>::infinity();
        for (const auto& box : boxes) best = std::min(best, box.squaredExteriorDistance(p));
        // Boxes at less than the last bits of the distance are the same to the search.
        EXPECT_NEAR(nearestByTree(tree, boxes, p), best, 1e-14 * best) << count << " boxes";
      }
    }
}

TEST(BoxTree, WithinVisitsEveryBoxInReachOnce) {
  test::Random random(2);
  for (const int leaf_size : {1, 4, 9}) {
    const Boxes boxes = randomBoxes(random, 700, 0.1);
    const BoxTree tree(boxes, leaf_size);
    for (int k = 0; k < 100; ++k) {
      const Vector3d p = random.inCube(1.5);
      const double radius = random.unit();
      std::vector<int> visits(boxes.size(), 0);
      tree.searchWithin(p, radius * radius, [&](std::size_t first, std::size_t count) {
        EXPECT_LE(count, static_cast<std::size_t>(leaf_size));
        for (std::size_t s = first; s < first + count; ++s) ++visits[tree.order()[s]];
      });
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        EXPECT_LE(visits[i], 1);
        if (boxes[i].exteriorDistance(p) <= radius * (1 - 1e-12)) {
          EXPECT_EQ(visits[i], 1) << "box " << i;
        }
      }
    }
  }
}

// The boxes are kept in float, about their middle: no item may be lost by that, whatever the scale and wherever the point.
TEST(BoxTree, LosesNoItemToRounding) {
  test::Random random(4);
  for (const double scale : {1e-200, 1e-12, 1.0, 1e9})
    for (const double offset : {0.0, 1e6})
      for (const double away : {0.5, 3.0, 9.0, 1e6, 1e25}) {
        Boxes boxes = randomBoxes(random, 200, 1e-4);
        for (auto& box : boxes) box = {scale * (box.min() + Vector3d::Constant(offset)), scale * (box.max() + Vector3d::Constant(offset))};
        const BoxTree tree(boxes);
        for (int k = 0; k < 50; ++k) {
          const Vector3d p = scale * (away * random.inCube(1) + Vector3d::Constant(offset));
          const auto& target = boxes[static_cast<std::size_t>(k)];
          const double reach2 = target.squaredExteriorDistance(p);
          double best = std::numeric_limits<double>::infinity();
          for (const auto& box : boxes) best = std::min(best, box.squaredExteriorDistance(p));
          EXPECT_NEAR(nearestByTree(tree, boxes, p), best, 1e-14 * best) << scale << " " << offset << " " << away;
          bool visited = false;
          tree.searchWithin(p, reach2, [&](std::size_t first, std::size_t count) {
            for (std::size_t s = first; s < first + count; ++s) visited = visited || tree.order()[s] == static_cast<std::uint32_t>(k);
          });
          EXPECT_TRUE(visited) << scale << " " << offset << " " << away;
        }
      }
}

TEST(BoxTree, OrderIsAPermutation) {
  test::Random random(3);
  const BoxTree tree(randomBoxes(random, 1000, 0.2));
  EXPECT_EQ(std::set<std::uint32_t>(tree.order().begin(), tree.order().end()).size(), 1000u);
}

TEST(BoxTree, EmptyTreeFindsNothing) {
  const BoxTree tree{Boxes{}};
  double limit2 = 1;
  tree.searchNearest(Vector3d::Zero(), limit2, [](std::size_t, std::size_t) { FAIL(); });
  tree.searchWithin(Vector3d::Zero(), 1, [](std::size_t, std::size_t) { FAIL(); });
}

// Without a bound on the depth, such inputs overflow the stack of a search.
TEST(BoxTree, EqualAndEverSmallerBoxesStaySearchable) {
  Boxes equal(20000, Eigen::AlignedBox3d(Vector3d::Zero(), Vector3d::Ones()));
  EXPECT_EQ(nearestByTree(BoxTree(equal), equal, Vector3d(2, 0, 0)), 1);
  Boxes shrinking;
  for (int i = 0; i < 1000; ++i) {
    const Vector3d p(std::ldexp(1.0, -i), 0, 0);
    shrinking.emplace_back(p, p);
  }
  const BoxTree tree(shrinking, 1);
  EXPECT_EQ(nearestByTree(tree, shrinking, Vector3d(-1, 0, 0)), 1);
  EXPECT_EQ(nearestByTree(tree, shrinking, Vector3d(2, 0, 0)), 1);
}

}  // namespace
}  // namespace spheretree::builder
