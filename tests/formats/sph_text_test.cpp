// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/sph_text.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "spheretree/formats/errors.h"
#include "support/sample_trees.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

std::string sphRefusal(const std::string& text) {
  return test::refusalOf<FormatError>([&] { (void)parseSph(text, "a.sph"); });
}

TEST(SphText, IsWrittenToTheLetter) {
  SphereTree tree;
  tree.branching = 2;
  tree.origin_mm = {100, 0, 0};
  tree.cover = {{0, 0, 0, 2}, {1, 0.1f, 0, 1}, {-1, 0, 0, 1.5f}, {1, 0, -0.5f, 0.25f}};
  tree.child_count = {2, 1, 0, 0};
  ASSERT_TRUE(linkNodes(tree));
  encloseDescendants(tree);
  tree.bound[1] = {1, 2, 3, 4};
  EXPECT_EQ(writeSph(tree, SphereKind::Cover),
            "3 2\n"
            "100 0 0 2 1\n"
            "101 0.100000001 0 1 1\n"
            "99 0 0 1.5 1\n"
            "101 0 -0.5 0.25 1\n"
            "0 0 0 -1 0\n"
            "0 0 0 -1 0\n"
            "0 0 0 -1 0\n");
  EXPECT_NE(writeSph(tree, SphereKind::Bound).find("\n101 2 3 4 1\n99 0 0 1.5 1\n"), std::string::npos) << "leaves keep their cover sphere";
}

TEST(SphText, ReturnsSpheresAndTopologyBitForBit) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const SphereTree tree = test::randomTree(seed, 1 + static_cast<int>(seed % 6), 2 + static_cast<int>(seed % 4));
    const SphereTree again = parseSph(writeSph(tree, SphereKind::Cover), "a.sph");
    EXPECT_EQ(again.cover, tree.cover);
    EXPECT_EQ(again.bound, tree.bound);
    EXPECT_EQ(again.child_count, tree.child_count);
    EXPECT_EQ(again.statistics, tree.statistics);
    EXPECT_EQ(again.branching, tree.branching);
    EXPECT_EQ(findFault(again), "");
  }
}

TEST(SphText, ReadsWhatTheToolkitWrites) {
  const SphereTree tree = parseSph(
      "2 3\r\n"
      "0.000000 0.000000 0.000000 2.000000 1.000000\r\n"
      "0.000000 0.000000 0.000000 -0.000000 0.000000\r\n"
      "1.000000\t0.500000 0.000000 1.000000\r\n"
      "0 0 0 -1 -1\n"
      "0.25 0.5\nfurther text\n",
      "a.sph");
  EXPECT_EQ(tree.cover, (std::vector<Sphere>{{0, 0, 0, 2}, {1, 0.5f, 0, 1}}));
  EXPECT_EQ(tree.child_count, (std::vector<std::uint8_t>{1, 0}));
}

TEST(SphText, ReadsAnyLineEnds) {
  const SphereTree tree = parseSph("2 2\n0 0 0 2 1\n+1 0 0 1 1\n0 0 0 -1 0\n", "a.sph");
  EXPECT_EQ(parseSph("2 2\r\n0 0 0 2 1\r\n1 0 0 1 1\r\n0 0 0 -1 0\r\n", "a.sph"), tree);
  EXPECT_EQ(parseSph("2 2\r0 0 0 2 1\r1 0 0 1 1\r0 0 0 -1 0\r", "a.sph"), tree);
}

TEST(SphText, PutsInnerSiblingsFirst) {
  const SphereTree tree = parseSph("3 2\n0 0 0 9 1\n1 0 0 1 1\n2 0 0 2 1\n0 0 0 -1 0\n0 0 0 -1 0\n0 0 0 -1 0\n3 0 0 3 1\n", "a.sph");
  EXPECT_EQ(tree.cover, (std::vector<Sphere>{{0, 0, 0, 9}, {2, 0, 0, 2}, {1, 0, 0, 1}, {3, 0, 0, 3}}));
  EXPECT_EQ(tree.child_count, (std::vector<std::uint8_t>{2, 1, 0, 0}));
}

TEST(SphText, KeepsSpheresApartFarFromTheFramesOrigin) {
  const SphereTree tree = parseSph("2 2\n1000000.5 0 0 1 1\n1000000.75 0.125 0 0.5 1\n0 0 0 -1 0\n", "a.sph");
  EXPECT_EQ(tree.origin_mm[0], 1000000.5);
  EXPECT_EQ(tree.cover[1], (Sphere{0.25f, 0.125f, 0, 0.5f}));
}

TEST(SphText, RefusesWithTheLine) {
  const std::string rest = "\n0 0 0 -1 0\n0 0 0 -1 0\n";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "is empty"},
      {" \n\n", "is empty"},
      {"x 2\n", "line 1: the number of levels is \"x\""},
      {"2\n", "line 1: the branching"},
      {"0 8\n", "line 1: the number of levels is \"0\", not a whole number from 1 to 6"},
      {"7 8\n", "line 1: the number of levels is \"7\""},
      {"99999999999999999999 8\n", "line 1: the number of levels"},
      {"6 1\n", "line 1: the branching is \"1\", not a whole number from 2 to 8"},
      {"6 2000000000\n", "line 1: the branching is \"2000000000\""},
      {"6 8\n0 0 0 1 1\n", "ends after 1 of 37449 nodes"},
      {"2 2\n0 0 0 nan 1" + rest, "line 2: node 0: the radius"},
      {"2 2\n0 0 0 inf 1" + rest, "line 2: node 0: the radius"},
      {"2 2\n0 0 0 0 1" + rest, "line 2: node 0: the radius"},
      {"2 2\n0 0 0 1e-60 1" + rest, "line 2: node 0: the radius"},
      {"2 2\n0 0 0 1e60 1" + rest, "line 2: node 0: the radius"},
      {"2 2\n0 1e40 0 1 1" + rest, "line 2: node 0: a coordinate"},
      {"2 2\n0 1e400 0 1 1" + rest, "line 2: node 0: a coordinate"},
      {"2 2\n0 nan 0 1 1" + rest, "line 2: node 0: a coordinate"},
      {"2 2\n0 0 1" + rest, "line 2: node 0: the radius is \"\""},
      {"2 2\n0 0 1x 1 1" + rest, "line 2: node 0: a coordinate is \"1x\""},
      {"2 2\n0 0 \x01\xff 1 1" + rest, "\"?\xff\""},
      {"2 2\n0 0 0 -1 1" + rest, "line 2: the root is unused"},
      {"3 2\n0 0 0 1 1" + rest + "0 0 0 1 1\n0 0 0 1 1\n0 0 0 1 1\n0 0 0 1 1\n", "line 5: node 3: is used, but its parent, node 1"},
      {"2 2\n3e38 0 0 3e38 1\n-3e38 0 0 3e38 1\n0 0 0 -1 0\n", "not finite"},
  };
  for (const auto& [text, words] : cases)
    EXPECT_NE(sphRefusal(text).find(words), std::string::npos) << words << "\nfound: " << sphRefusal(text);
}

TEST(SphText, SurvivesTruncationAndMutation) {
  test::Random random(3);
  const std::string whole = writeSph(test::randomTree(2, 3, 3), SphereKind::Cover);
  int accepted = 0, refused = 0;
  const auto feed = [&](const std::string& text) {
    try {
      const SphereTree tree = parseSph(text, "a.sph");
      ASSERT_EQ(findFault(tree), "");
      ++accepted;
    } catch (const FormatError&) {
      ++refused;
    }
  };
  for (std::size_t size = 0; size < whole.size(); ++size) feed(whole.substr(0, size));
  const std::string letters = "0123456789.-+eE \n\t\rnaif\xff";
  for (int i = 0; i < 20000; ++i) {
    std::string text = whole;
    for (std::uint64_t k = 0; k <= random.below(4); ++k) text[random.below(text.size())] = letters[random.below(letters.size())];
    feed(text);
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace spheretree::formats
