// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/split/tooth_numbers.h"

#include <gtest/gtest.h>

#include <set>

namespace spheretree::pipeline {
namespace {

TEST(ToothNumbers, UniversalRunsFromTheUpperRightWisdomToothRoundToTheLowerRight) {
  std::set<std::int32_t> found;
  for (std::int32_t n = 1; n <= 32; ++n) {
    ASSERT_TRUE(fdiOfUniversal(n));
    EXPECT_TRUE(isFdi(*fdiOfUniversal(n)));
    EXPECT_EQ(isUpperFdi(*fdiOfUniversal(n)), n <= 16);
    found.insert(*fdiOfUniversal(n));
  }
  EXPECT_EQ(found.size(), 32u);
  // ADA and ISO 3950: corners of the table.
  for (const auto& [universal, fdi] :
       {std::pair{1, 18}, {3, 16}, {8, 11}, {9, 21}, {16, 28}, {17, 38}, {24, 31}, {25, 41}, {30, 46}, {32, 48}})
    EXPECT_EQ(fdiOfUniversal(universal), fdi);
  for (const int none : {0, -1, 33}) EXPECT_FALSE(fdiOfUniversal(none));
}

TEST(ToothNumbers, PalmerNamesTheQuadrant) {
  EXPECT_EQ(fdiOfPalmer("UR6"), 16);
  EXPECT_EQ(fdiOfPalmer("ul-1"), 21);
  EXPECT_EQ(fdiOfPalmer("LL8"), 38);
  EXPECT_EQ(fdiOfPalmer("LR E"), 85);
  for (const char* none : {"", "UR", "UR9", "UR0", "XR1", "URF", "UR16"}) EXPECT_FALSE(fdiOfPalmer(none)) << none;
}

TEST(ToothNumbers, FdiHasThirtyTwoPermanentAndTwentyDeciduousTeeth) {
  int permanent = 0, deciduous = 0;
  for (std::int32_t n = -5; n < 1000; ++n) (n < 50 ? permanent : deciduous) += isFdi(n);
  EXPECT_EQ(permanent, 32);
  EXPECT_EQ(deciduous, 20);
  EXPECT_TRUE(isUpperFdi(55));
  EXPECT_FALSE(isUpperFdi(75));
}

TEST(ToothNumbers, NamesOfParts) {
  EXPECT_EQ(labelOfName("Tooth_16.001", "fdi"), 16);
  EXPECT_EQ(labelOfName("tooth 3", "universal"), 16);
  EXPECT_EQ(labelOfName("crown UR6", "palmer"), 16);
  EXPECT_EQ(labelOfName("Gingiva lower", "fdi"), 0);
  EXPECT_FALSE(labelOfName("bracket", "fdi"));
}

}  // namespace
}  // namespace spheretree::pipeline
