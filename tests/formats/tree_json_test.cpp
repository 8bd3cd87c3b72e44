// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/tree_json.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "support/sample_trees.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::replaced;

std::string refusal(const std::string& text) {
  return test::refusalOf<FormatError>([&] { (void)parseTreeJson(text, "a.json"); });
}

TEST(TreeJson, ReturnsEveryTreeBitForBit) {
  std::vector<SphereTree> trees{test::threeLevelTree(), test::treeOf({0})};
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    trees.push_back(test::randomTree(seed, 1 + static_cast<int>(seed % 6), 2 + static_cast<int>(seed % 7)));
  trees[1].cover[0].x = -0.0f;
  for (const SphereTree& tree : trees) {
    const SphereTree again = parseTreeJson(writeTreeJson(tree), "a.json");
    EXPECT_EQ(encodeSphereTree(again), encodeSphereTree(tree));
    EXPECT_EQ(writeTreeJson(again), writeTreeJson(tree));
  }
}

TEST(TreeJson, ComputesWhatIsLeftOut) {
  const SphereTree tree = parseTreeJson(
      R"({"schema": "spheretree.tree/1", "branching": 2,
          "nodes": [{"cover": [0, 0, 0, 1], "child_count": 1}, {"cover": [10, 0, 0, 2.5], "child_count": 0}]})",
      "a.json");
  EXPECT_EQ(findFault(tree), "");
  ASSERT_EQ(tree.bound.size(), 1u);
  EXPECT_NEAR(tree.bound[0].radius, 6.75, 3e-4);
  EXPECT_EQ(tree.statistics[1].overhang_bound, kUnproven);
}

TEST(TreeJson, RefusesWithThePath) {
  const std::string good = writeTreeJson(test::threeLevelTree());
  EXPECT_EQ(refusal(good), "");
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "is not JSON"},
      {"[", "is not JSON"},
      {"[]", "the text is not an object"},
      {"null", "the text is not an object"},
      {"{}", "has no \"schema\""},
      {replaced(good, "tree/1", "tree/2"), "schema is not \"spheretree.tree/1\""},
      {replaced(good, "\"unit\": \"mm\"", "\"unit\": \"m\""), "unit is not \"mm\""},
      {replaced(good, "\"branching\": 3", "\"branching\": -3"), "branching is not a whole number"},
      {replaced(good, "\"branching\": 3", "\"branching\": 1"), "branching 1"},
      {replaced(good, "\"child_count\":3", "\"child_count\":3.5"), "nodes[0].child_count is not a whole number"},
      {replaced(good, "\"child_count\":3", "\"child_count\":4"), "nodes do not make one tree"},
      {replaced(good, "\"first_child\":1", "\"first_child\":2"), "nodes[0].first_child is not 1"},
      {replaced(good, "{\"cover\":[", "{\"cover\":[1,"), "nodes[0].cover is not [x, y, z, radius]"},
      {replaced(good, "{\"cover\":[", "{\"cover\":[\"1\","), "nodes[0].cover is not [x, y, z, radius]"},
      {replaced(good, "\"bound\"", "\"bond\""), "1 bounding spheres for 2"},
      {replaced(good, "\"nodes\"", "\"knots\""), "has no \"nodes\""},
      {replaced(good, "\"seed\": ", "\"seed\": -"), "provenance.seed"},
      {replaced(good, "\"mesh_hash\": \"0", "\"mesh_hash\": \"G"), "provenance.mesh_hash is not 32 digits"},
      {replaced(good, "\"mesh_hash\": \"0", "\"mesh_hash\": \""), "provenance.mesh_hash is not 32 digits"},
      {replaced(good, "\"spheres\": 3", "\"spheres\": 4"), "statistics of level 1"},
      {R"({"schema":"spheretree.tree/1","branching":2,"nodes":[{"cover":[0,0,1e39,1],"child_count":0}]})",
       "nodes[0].cover[2] is too large"},
      {R"({"schema":"spheretree.tree/1","branching":2,"nodes":[{"cover":[0,0,1e999,1],"child_count":0}]})", "is not JSON"},
      {R"({"schema":"spheretree.tree/1","branching":2,"nodes":[{"cover":[0,0,0,0],"child_count":0}]})", "nodes[0].cover[3] is not above 0"},
      {R"({"schema":"spheretree.tree/1","branching":2,"nodes":[]})", "nodes has 0 nodes"},
      {R"({"schema":"spheretree.tree/1","branching":2,"nodes":[{"cover":[0,0,0,1],"bound":[0,0,0,1],"child_count":0}]})",
       "nodes[0].bound belongs to a node without children"},
  };
  for (const auto& [text, words] : cases) EXPECT_NE(refusal(text).find(words), std::string::npos) << words << "\nfound: " << refusal(text);
}

TEST(TreeJson, SurvivesDeepNesting) { EXPECT_NE(refusal(std::string(2000000, '[')), ""); }

TEST(TreeJson, SurvivesTruncationAndMutation) {
  test::Random random(4);
  const std::string whole = writeTreeJson(test::threeLevelTree());
  for (std::size_t size = 0; size + 2 < whole.size(); ++size) ASSERT_NE(refusal(whole.substr(0, size)), "") << size;
  const std::string letters = "0123456789.-e{}[]\",:tn \\\xff";
  int refused = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text = whole;
    for (std::uint64_t k = 0; k <= random.below(3); ++k) text[random.below(text.size())] = letters[random.below(letters.size())];
    try {
      ASSERT_EQ(findFault(parseTreeJson(text, "a.json")), "");
    } catch (const FormatError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace spheretree::formats
