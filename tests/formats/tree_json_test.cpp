// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/tree_json.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "spheretree/core/sphere_tree_codec.h"
#include "spheretree/formats/errors.h"
#include "support/sample_skins.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::replaced;

std::string treeRefusal(const std::string& text) {
  return test::refusalOf<FormatError>([&] { (void)parseTreeJson(text, "a.json"); });
}

TEST(TreeJson, ReturnsEveryTreeBitForBit) {
  std::vector<SphereTree> trees{test::threeLevelTree(), test::treeOf({0})};
  for (std::uint64_t seed = 1; seed <= 20; ++seed)
    trees.push_back(test::randomTree(seed, 1 + static_cast<int>(seed % 6), 2 + static_cast<int>(seed % 7)));
  trees[1].cover[0].x = -0.0f;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SphereTree tree = test::randomTree(seed, 4, 5);
    trees.push_back(test::withSearch(tree, 2 + seed % 7));
    trees.push_back(test::withSkin(tree, test::randomSkin(seed)));
    trees.push_back(test::withSkin(trees[trees.size() - 2], test::randomSkin(seed + 100)));
  }
  for (const SphereTree& tree : trees) {
    const SphereTree again = parseTreeJson(writeTreeJson(tree), "a.json");
    EXPECT_EQ(encodeSphereTree(again), encodeSphereTree(tree));
    EXPECT_EQ(again, tree);
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
  EXPECT_EQ(treeRefusal(good), "");
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "is empty, not a sphere-tree"},
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
  for (const auto& [text, words] : cases)
    EXPECT_NE(treeRefusal(text).find(words), std::string::npos) << words << "\nfound: " << treeRefusal(text);
}

TEST(TreeJson, NamesWhatIsWrongInSearchAndSkin) {
  const std::string good = writeTreeJson(test::withSkin(test::withSearch(test::treeOf({3, 0, 0, 0})), test::boxSkin({1, 2, 3})));
  EXPECT_EQ(treeRefusal(good), "");
  // A number or a record put in front of the first one of an array.
  const auto with = [&](const std::string& array, const std::string& first) {
    return replaced(good, "\"" + array + "\": [", "\"" + array + "\": [" + first + ",");
  };
  const std::vector<std::pair<std::string, std::string>> cases{
      {replaced(good, "\"search\": {\"inner\"", "\"search\": {\"inn\""), "search has no \"inner\""},
      {with("item", "65536"), "search.item[0] is not a whole number from 0 to 65535"},
      {with("item", "0.5"), "search.item[0] is not a whole number"},
      {with("item", "0"), "search over the leaves: the search tree orders 4 of 3 items"},
      {with("inner", "[0]"), "search.inner[0] does not have 6 numbers"},
      {with("inner", "[1e39,0,0,1,0,1]"), "search.inner[0][0] is too large"},
      {with("inner", "[0,0,0,1,0,256]"), "search.inner[0][5] is not a whole number from 0 to 255"},
      {replaced(good, "\"low_mm\":[", "\"low_mm\":[1,"), "skin.low_mm is not [x, y, z]"},
      {replaced(good, "\"step_mm\":", "\"step_mm\":1e99,\"was\":"), "skin.step_mm is too large"},
      {replaced(good, "\"step_mm\":", "\"step_mm\":-1,\"was\":"), "step of positions"},
      {with("triangles", "[0,0,0]"), "skin.triangles[0] does not have 6 numbers"},
      {with("triangles", "[-1,0,0,0,0,0]"), "skin.triangles[0][0] is not a whole number from 0 to 65535"},
      {with("vertices", "[0,-1,0,0,0]"), "skin.vertices[0][1] is not a whole number from 0 to 4294967295"},
      {with("vertices", "[0,2097152,0,0,0]"), "vertex 0 of the skin: its position"},
      {with("vertices", "[0,0,0,0,32768]"), "skin.vertices[0][4] is not a whole number from -32768 to 32767"},
      {with("vertices", "[0,0,0,0,18446744073709551615]"), "skin.vertices[0][4] is not a whole number"},
      {with("edges", "[128,0,0,0,0,0]"), "skin.edges[0][0] is not a whole number from -128 to 127"},
      {with("edges", "[0,0,0,2,0,0]"), "edge 0 of the skin: its flag"},
      {with("edges", "1"), "skin.edges[0] is not an array"},
      {replaced(good, "\"triangles\": [", "\"triangles\": [], \"was\": ["), "the skin has no triangles"},
  };
  for (const auto& [text, words] : cases)
    EXPECT_NE(treeRefusal(text).find(words), std::string::npos) << words << "\nfound: " << treeRefusal(text);
}

TEST(TreeJson, BreaksLinesOfArrays) {
  const std::string text = writeTreeJson(test::withSkin(test::withSearch(test::randomTree(2, 4, 8)), test::roundSkin(2)));
  std::size_t longest = 0;
  for (std::size_t first = text.find("\"search\""); first < text.size();) {
    const std::size_t end = text.find('\n', first);
    longest = std::max(longest, end - first);
    first = end + 1;
  }
  EXPECT_LE(longest, 200u);
}

TEST(TreeJson, SurvivesDeepNesting) { EXPECT_NE(treeRefusal(std::string(2000000, '[')), ""); }

TEST(TreeJson, SurvivesTruncationAndMutation) {
  test::Random random(4);
  const std::string whole = writeTreeJson(test::threeLevelTree());
  for (std::size_t size = 0; size + 2 < whole.size(); ++size) ASSERT_NE(treeRefusal(whole.substr(0, size)), "") << size;
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
