// SPDX-License-Identifier: Apache-2.0
#include "free_arcs.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "support/random.h"

namespace spheretree::runtime {
namespace {

TEST(FreeArcs, SquareAnglesAreAnglesInOrder) {
  double before = -1;
  for (int k = 0; k < 360; ++k) {
    const double angle = k * kWholeTurn / 360, square = pseudoAngle(std::cos(angle), std::sin(angle));
    EXPECT_GT(square, before);
    EXPECT_NEAR(trueAngle(square), angle, 1e-12);
    before = square;
  }
}

TEST(FreeArcs, EveryEndNamesALeaf) {
  FreeArcs arcs;
  const auto whole = [&](std::vector<std::array<double, 2>> taken) {
    arcs.start();
    std::uint32_t k = 0;
    for (const auto& [low, high] : taken) arcs.take(low, high, k++);
    return arcs.whole();
  };
  EXPECT_EQ(whole({}).front().low_end, kNone);  // the whole circle
  // From 0 on, up to 0, over 0, and somewhere; what is left has the leaf at either end.
  for (const auto& taken : {std::array{0.0, 1.0}, std::array{3.0, 4.0}, std::array{3.0, 0.0}, std::array{3.5, 0.5}, std::array{1.0, 2.0}}) {
    const auto& pieces = whole({taken});
    ASSERT_EQ(pieces.size(), 1u) << taken[0];
    EXPECT_EQ(pieces[0].low_end, 0u) << taken[0];
    EXPECT_EQ(pieces[0].high_end, 0u) << taken[0];
    const double length = taken[1] - taken[0];
    EXPECT_DOUBLE_EQ(pieces[0].high - pieces[0].low, 4 - (length < 0 ? length + 4 : length)) << taken[0];
  }
  const auto& two = whole({{0.0, 1.0}, {2.0, 3.0}});
  ASSERT_EQ(two.size(), 2u);
  EXPECT_EQ(two[0].low_end, 0u);
  EXPECT_EQ(two[0].high_end, 1u);
  EXPECT_EQ(two[1].low_end, 1u);
  EXPECT_EQ(two[1].high_end, 0u);
  EXPECT_TRUE(whole({{0.0, 3.0}, {2.0, 0.5}}).empty());
}

// What u . (x, y) > most takes away, one after the other.
TEST(FreeArcs, WhatItDoesNotReachTakesNothing) {
  test::Random random(1);
  int spared = 0;
  for (int round = 0; round < 200; ++round) {
    FreeArcs arcs;
    arcs.start();
    for (std::uint32_t k = 0; k < 12 && !arcs.empty(); ++k) {
      const double angle = kWholeTurn * random.unit(), half = 1 + random.unit(), size = 3 * random.unit();
      const auto square = [](double a) { return pseudoAngle(std::cos(a), std::sin(a)); };
      const bool reaches = arcs.reaches(size * std::cos(angle), size * std::sin(angle), size * std::cos(half));
      const std::vector<FreeArcs::Piece> before = arcs.pieces();
      arcs.take(square(angle - half), square(angle + half), k);
      if (reaches) continue;
      ++spared;
      ASSERT_EQ(arcs.pieces().size(), before.size());
      for (std::size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(arcs.pieces()[i].low, before[i].low);
        EXPECT_EQ(arcs.pieces()[i].high, before[i].high);
      }
    }
  }
  EXPECT_GT(spared, 100);
}

}  // namespace
}  // namespace spheretree::runtime
