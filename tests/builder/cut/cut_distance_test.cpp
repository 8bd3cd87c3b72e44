// SPDX-License-Identifier: GPL-3.0-or-later
#include "cut/cut_distance.h"

#include <gtest/gtest.h>

#include <array>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

TEST(CutDistance, IsThatOfTheNearestRemovedPoint) {
  const DistanceField object(test::boxMesh({-5, -5, -5}, {5, 5, 5})), pulp(test::boxMesh({-1, -1, -1}, {1, 1, 1}));
  // Past an edge of the pulp at (1, 1): the nearest point of the path is (2, 2).
  const auto past = distanceOfCut(object, pulp, std::array{BurrPath{0.5, {{0.5, 3.5, 0}, {3.5, 0.5, 0.2}}}});
  ASSERT_TRUE(past && past->high);
  const double truth = std::sqrt(2.0) - 0.5;
  EXPECT_LE(past->low, truth);
  EXPECT_GE(*past->high, truth);
  EXPECT_LE(*past->high - past->low, 1e-4);
  const auto into = distanceOfCut(object, pulp, std::array{BurrPath{0.5, {{0, 0, 4}, {0, 0, 1.2}}}});
  ASSERT_TRUE(into && into->high);
  EXPECT_EQ(*into->high, 0);
  EXPECT_EQ(into->low, 0);
  const auto within = distanceOfCut(object, pulp, std::array{BurrPath{0.1, {{0, 0, 0}, {0, 0, 0}}}});
  ASSERT_TRUE(within && within->high);
  EXPECT_EQ(*within->high, 0);
  EXPECT_FALSE(distanceOfCut(object, pulp, {}));
}

TEST(CutDistance, CountsOnlyPointsOfTheObjectAsRemoved) {
  const DistanceField object(test::boxMesh({-5, -5, -5}, {5, 5, 5})), pulp(test::boxMesh({-1, -1, -1}, {1, 1, 1}));
  const auto outside = distanceOfCut(object, pulp, std::array{BurrPath{0.5, {{0, 0, 7}, {0, 0, 6}}}});
  ASSERT_TRUE(outside);
  EXPECT_NEAR(outside->low, 4.5, 1e-4);
  EXPECT_FALSE(outside->high);
}

}  // namespace
}  // namespace spheretree::builder
