// SPDX-License-Identifier: Apache-2.0
#include "tree/skin_json.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "support/sample_skins.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

const JsonSource kSkinSource{"a.json", "a skin"};

Skin skinFrom(const std::string& text) {
  const nlohmann::json json = parseJson(text, kSkinSource);
  return readSkinJson(JsonElement(json, "skin", kSkinSource));
}

SearchTree searchFrom(const std::string& text) {
  const nlohmann::json json = parseJson(text, kSkinSource);
  return readSearchJson(JsonElement(json, "search", kSkinSource));
}

/// Skins of every kind, and one whose numbers are the limits of their types.
std::vector<Skin> sampleSkins() {
  std::vector<Skin> skins{test::boxSkin({1, 2, 3}), test::roundSkin(2), test::ridgeSkin()};
  for (std::uint64_t seed = 1; seed <= 10; ++seed) skins.push_back(test::randomSkin(seed));
  Skin& last = skins.emplace_back(test::boxSkin({1, 1, 1}));
  using Float = std::numeric_limits<float>;
  last.low = {Float::lowest(), Float::denorm_min(), -0.0f};
  last.step = Float::max();
  last.triangles[0] = {{0, 65535, 1}, {65535, 0, 2}};
  last.vertices[0] = {{0, ~0u, 1}, {-32768, 32767}};
  last.edges[0] = {{-128, 127, 0}, 255, {32767, -32768}};
  last.search.inner_children[0] = 255;
  return skins;
}

TEST(SkinJson, RoundTripKeepsEveryNumber) {
  for (const Skin& skin : sampleSkins()) {
    const std::string text = writeSkinJson(skin);
    const Skin again = skinFrom(text);
    EXPECT_EQ(again, skin);
    EXPECT_EQ(writeSkinJson(again), text) << "the sign of a zero, too";
  }
  EXPECT_EQ(skinFrom(writeSkinJson({})), Skin{});
}

TEST(SkinJson, RoundTripKeepsTheSearchTree) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SearchTree search = test::withSearch(test::randomTree(seed, 4, 5), 2 + seed % 7).search;
    ASSERT_FALSE(search.item.empty());
    EXPECT_EQ(searchFrom(writeSearchJson(search)), search);
  }
}

TEST(SkinJson, LinesAreShortAndIndentedAndHoldManyRecords) {
  std::istringstream lines(writeSkinJson(test::roundSkin(3)));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line.substr(0, 11), "{\"low_mm\":[") << "the numbers of the whole skin share the first line";
  std::size_t count = 0, records = 0;
  for (; std::getline(lines, line); ++count) {
    EXPECT_EQ(line.substr(0, 2), "  ");
    EXPECT_LE(line.size(), 122u) << "120 characters of records, and a bracket and a comma at the end of an array: " << line;
    records += static_cast<std::size_t>(std::count(line.begin(), line.end(), ']'));
  }
  EXPECT_GT(records, 3 * count);
}

TEST(SkinJson, RefusesWithThePath) {
  const nlohmann::json good = nlohmann::json::parse(writeSkinJson(test::boxSkin({1, 2, 3})));
  const std::vector<std::tuple<std::string, nlohmann::json, std::string>> cases{
      {"/low_mm", {1, 2}, "skin.low_mm is not [x, y, z]."},
      {"/low_mm/1", "2", "skin.low_mm[1] is not a number."},
      {"/step_mm", 1e39, "skin.step_mm is too large for a float."},
      {"/triangles", 3, "skin.triangles is not an array."},
      {"/triangles/4", {1, 2, 3, 4, 5}, "skin.triangles[4] does not have 6 numbers."},
      {"/triangles/4/2", 65536, "skin.triangles[4][2] is not a whole number from 0 to 65535."},
      {"/triangles/4/5", -1, "skin.triangles[4][5] is not a whole number from 0 to 65535."},
      {"/vertices/0", {1, 2, 3, 4}, "skin.vertices[0] does not have 5 numbers."},
      {"/vertices/1/0", 4294967296, "skin.vertices[1][0] is not a whole number from 0 to 4294967295."},
      {"/vertices/1/4", 32768, "skin.vertices[1][4] is not a whole number from -32768 to 32767."},
      {"/edges/2/0", 128, "skin.edges[2][0] is not a whole number from -128 to 127."},
      {"/edges/2/3", 256, "skin.edges[2][3] is not a whole number from 0 to 255."},
      {"/edges/2/4", 0.5, "skin.edges[2][4] is not a whole number from -32768 to 32767."},
      {"/inner/0", {0, 0, 0, 1, 2}, "skin.inner[0] does not have 6 numbers."},
      {"/inner/0/5", 256, "skin.inner[0][5] is not a whole number from 0 to 255."}};
  const auto refusal = [](const nlohmann::json& json) { return test::refusalOf<FormatError>([&] { (void)skinFrom(json.dump()); }); };
  EXPECT_EQ(refusal(good), "");
  for (const auto& [place, value, message] : cases) {
    nlohmann::json bad = good;
    bad[nlohmann::json::json_pointer(place)] = value;
    EXPECT_EQ(refusal(bad), "a.json: " + message);
  }
  for (const auto& [key, value] : good.items()) {
    nlohmann::json bad = good;
    bad.erase(key);
    EXPECT_EQ(refusal(bad), "a.json: skin has no \"" + key + "\".");
  }
}

}  // namespace
}  // namespace spheretree::formats
