// SPDX-License-Identifier: Apache-2.0
#include "piece/margin_policy.h"

#include <gtest/gtest.h>

namespace spheretree::runtime {
namespace {

TEST(MarginPolicy, TheFirstMarginIsTheWayToTheHandWithinBounds) {
  EXPECT_DOUBLE_EQ(MarginPolicy(0.04, 1, false).value(), 0.04);
  EXPECT_DOUBLE_EQ(MarginPolicy(0, 1, false).value(), kMinMargin);
  EXPECT_DOUBLE_EQ(MarginPolicy(50, 2, false).value(), 3.05);  // a tool that is far behind does not look that far ahead
  EXPECT_DOUBLE_EQ(MarginPolicy(50, 2, true).value(), kContactMargin);
  EXPECT_TRUE(MarginPolicy(1, 1, true).needsSearch());
}

TEST(MarginPolicy, WhatIsLeftIsTheMarginLessTheWay) {
  MarginPolicy margin(0.5, 1, true);
  margin.searched();
  EXPECT_FALSE(margin.needsSearch());
  margin.use(0.125);
  margin.use(0.25);
  EXPECT_DOUBLE_EQ(margin.left(), 0.125);
  margin.searched();
  EXPECT_DOUBLE_EQ(margin.left(), margin.value());
}

TEST(MarginPolicy, ShorteningEndsAtTheContactMargin) {
  MarginPolicy margin(10, 10, false);
  EXPECT_TRUE(margin.shorten(false));
  EXPECT_DOUBLE_EQ(margin.value(), 2.5);
  EXPECT_TRUE(margin.shorten(false));
  EXPECT_DOUBLE_EQ(margin.value(), kContactMargin);
  EXPECT_FALSE(margin.shorten(false));
  EXPECT_DOUBLE_EQ(margin.value(), kContactMargin);
}

TEST(MarginPolicy, AfterAFullListNoMarginIsLarger) {
  MarginPolicy margin(1, 1, true);
  EXPECT_TRUE(margin.shorten(true));
  EXPECT_TRUE(margin.shorten(true));
  const double smallest_that_was_full = margin.value();
  EXPECT_DOUBLE_EQ(smallest_that_was_full, 1.0 / 16);
  margin.searched();
  margin.growAlong(0.01, 10);
  EXPECT_TRUE(margin.needsSearch());
  EXPECT_DOUBLE_EQ(margin.value(), smallest_that_was_full);
  EXPECT_TRUE(margin.widenForBodies(1, 5));
  EXPECT_DOUBLE_EQ(margin.value(), smallest_that_was_full);
  margin.growFree(10);
  EXPECT_DOUBLE_EQ(margin.value(), smallest_that_was_full);
  while (margin.shorten(true)) {
  }
  EXPECT_DOUBLE_EQ(margin.value(), kMinMargin);
}

TEST(MarginPolicy, BodiesGetRoomForTheirWayAndForThePush) {
  MarginPolicy margin(0.1, 1, true);
  EXPECT_TRUE(margin.widenForBodies(0.1, 0.3));  // the first search is due anyway
  EXPECT_DOUBLE_EQ(margin.value(), 0.1 + kCarriedMargin * 0.3);
  margin.searched();
  EXPECT_FALSE(margin.widenForBodies(0.1, 0.3));
  EXPECT_DOUBLE_EQ(margin.shareOfBodies(0.3), 1);
  EXPECT_DOUBLE_EQ(margin.shareOfBodies(0.7), 0.5);
  EXPECT_TRUE(margin.widenForBodies(0.1, 0.7));
  EXPECT_DOUBLE_EQ(margin.value(), 0.1 + kCarriedMargin * 0.7);
}

TEST(MarginPolicy, InFreeSpaceItGrowsFourfoldButNotBeyondTheHand) {
  MarginPolicy margin(0.5, 1, false);
  margin.searched();
  margin.growFree(100);
  EXPECT_TRUE(margin.needsSearch());
  EXPECT_DOUBLE_EQ(margin.value(), 2);
  margin.growFree(3);
  EXPECT_DOUBLE_EQ(margin.value(), 3);
}

TEST(MarginPolicy, AtContactsItGrowsOnlyIfTheRestDoesNotFit) {
  MarginPolicy margin(0.1, 1, true);
  margin.searched();
  margin.growAlong(0.9, 1);  // 0.1 mm are left of the margin and of the way
  EXPECT_FALSE(margin.needsSearch());
  EXPECT_DOUBLE_EQ(margin.value(), 0.1);
  margin.growAlong(0.5, 1);
  EXPECT_TRUE(margin.needsSearch());
  EXPECT_DOUBLE_EQ(margin.value(), 0.4);
  margin.searched();
  margin.use(0.4);
  margin.growAlong(0.1, 10);
  EXPECT_DOUBLE_EQ(margin.value(), kContactMargin);
}

TEST(MarginPolicy, ShortPiecesNarrowItWithoutASearch) {
  MarginPolicy margin(1, 1, true);
  margin.searched();
  EXPECT_FALSE(margin.narrow(0.1));  // eight of these would need nearly all of the margin
  EXPECT_DOUBLE_EQ(margin.value(), 1);
  margin.use(0.2);
  EXPECT_TRUE(margin.narrow(0.01));
  EXPECT_DOUBLE_EQ(margin.value(), kPiecesAhead * 0.01 + kMinMargin);
  EXPECT_DOUBLE_EQ(margin.left(), margin.value());
  EXPECT_FALSE(margin.needsSearch());
}

TEST(MarginPolicy, FeltReachCoversTheExpectedWay) {
  MarginPolicy margin(1, 1, true);
  EXPECT_DOUBLE_EQ(margin.feltReach(), kFeltReach);
  margin.feelWithin(0.05);
  EXPECT_DOUBLE_EQ(margin.feltReach(), 0.05 + kMinMargin);
  margin.feelWithin(5);
  EXPECT_DOUBLE_EQ(margin.feltReach(), kFeltReach);
}

}  // namespace
}  // namespace spheretree::runtime
