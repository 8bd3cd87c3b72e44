// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/nearest_word.h"

#include <gtest/gtest.h>

#include <array>

namespace spheretree::formats {
namespace {

TEST(EditDistance, CountsLettersInsertedDroppedAndChanged) {
  EXPECT_EQ(editDistance("", ""), 0u);
  EXPECT_EQ(editDistance("", "abc"), 3u);
  EXPECT_EQ(editDistance("abc", ""), 3u);
  EXPECT_EQ(editDistance("level", "levels"), 1u);
  EXPECT_EQ(editDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(editDistance("bulid", "build"), 1u);  // two exchanged letters are one change
}

TEST(EditDistance, IsAMetric) {
  constexpr std::array<std::string_view, 5> kWords{"", "mesh", "mash", "smash", "tree"};
  for (const std::string_view a : kWords)
    for (const std::string_view b : kWords) {
      EXPECT_EQ(editDistance(a, b) == 0, a == b);
      EXPECT_EQ(editDistance(a, b), editDistance(b, a));
      for (const std::string_view c : kWords) EXPECT_LE(editDistance(a, c), editDistance(a, b) + editDistance(b, c));
    }
}

TEST(NearestWord, IsTheFirstOfTheNearest) {
  constexpr std::array<std::string_view, 3> kKnown{"build", "batch", "check"};
  EXPECT_EQ(nearestWord("biuld", kKnown), "build");
  EXPECT_EQ(nearestWord("chek", kKnown), "check");
}

TEST(NearestWord, PrefersAWordWithThisBeginning) {
  constexpr std::array<std::string_view, 4> kKnown{"help", "tolerance_mm", "tolerance", "repair"};
  EXPECT_EQ(nearestWord("tol", kKnown), "tolerance");
  EXPECT_EQ(nearestWord("tolerance_", kKnown), "tolerance_mm");
}

TEST(NearestWord, IsNoneWhereNoneIsClose) {
  constexpr std::array<std::string_view, 5> kKnown{"help", "progress", "quiet", "repair", "name"};
  for (const char* word : {"scale", "dry-run", "out", "version", "view", "unit", "x", ""})
    EXPECT_FALSE(nearestWord(word, kKnown)) << word << ": " << *nearestWord(word, kKnown);
}

}  // namespace
}  // namespace spheretree::formats
