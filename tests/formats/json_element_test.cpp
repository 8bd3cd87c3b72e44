// SPDX-License-Identifier: Apache-2.0
#include "text/json_element.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>

namespace spheretree::formats {
namespace {

const JsonSource kSource{"mouth.scene.json", "a scene"};

std::string messageOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const FormatError& error) {
    return error.what();
  }
  return "no error";
}

std::string refusal(const std::string& text) {
  return messageOf([&] { parseJson(text, kSource); });
}

TEST(ParseJson, SaysLineAndColumnAndWhatPeopleMeant) {
  EXPECT_EQ(refusal("{\"a\": 1,\n \"b\": NaN}"),
            "mouth.scene.json: line 2, column 7: is not JSON: JSON has no NaN or infinity; give a number.");
  EXPECT_EQ(refusal("{\"a\": [1, 2,]}"),
            "mouth.scene.json: line 1, column 13: is not JSON: a comma before a closing bracket, or a value is missing.");
  EXPECT_EQ(refusal("{\"a\": 'x'}"), "mouth.scene.json: line 1, column 7: is not JSON: texts stand in double quotation marks.");
  EXPECT_EQ(refusal("// mine\n{}"), "mouth.scene.json: line 1, column 1: is not JSON: JSON has no comments; remove them.");
  EXPECT_NE(refusal("{\"a\": [1, 2").find("it ends too early"), std::string::npos);
  EXPECT_EQ(refusal("[1e999]"), "mouth.scene.json: is not JSON: the number \"1e999\" is too large.");
}

TEST(ParseJson, NamesAFileOfAnotherKind) {
  EXPECT_EQ(refusal("v 0 0 0\nv 1 0 0\n"), "mouth.scene.json: is a mesh (OBJ), not a scene.");
  EXPECT_EQ(refusal(""), "mouth.scene.json: is empty, not a scene.");
}

TEST(ParseJson, RefusesAKeyThatStandsTwiceInOneObjectOnly) {
  EXPECT_NE(refusal("{\"a\": 1, \"b\": {\"c\": 1, \"c\": 2}}").find("\"c\" stands twice"), std::string::npos);
  EXPECT_EQ(refusal("{\"a\": {\"a\": 1}, \"b\": {\"a\": 2}}"), "no error");
}

TEST(JsonElement, NamesThePathOfWhatIsWrong) {
  const nlohmann::json value = parseJson("{\"objects\": [{\"mass\": 1}, {\"mass\": \"heavy\"}], \"more\": {\"count\": -1}}", kSource);
  const JsonElement top(value, "", kSource);
  EXPECT_EQ(top.at("objects").size(), 2u);
  EXPECT_EQ(top.at("objects").item(0).at("mass").number(), 1);
  EXPECT_EQ(messageOf([&] { top.at("objects").item(1).at("mass").number(); }), "mouth.scene.json: objects[1].mass is not a number.");
  EXPECT_EQ(messageOf([&] { top.at("tool"); }), "mouth.scene.json: the text has no \"tool\".");
  EXPECT_EQ(messageOf([&] { top.at("more").at("count").whole(9); }), "mouth.scene.json: more.count is not a whole number from 0 to 9.");
  EXPECT_EQ(top.at("more").at("count").integer(-1, 1), -1);
  EXPECT_EQ(messageOf([&] { top.at("more").size(); }), "mouth.scene.json: more is not an array.");
  EXPECT_EQ(messageOf([&] { top.text(); }), "mouth.scene.json: the text is not a text.");
}

TEST(JsonElement, BoundsAreInclusive) {
  const nlohmann::json value = parseJson("{\"least\": 0, \"most\": 18446744073709551615, \"half\": 0.5, \"large\": 1e39}", kSource);
  const JsonElement top(value, "", kSource);
  EXPECT_EQ(top.at("least").whole(3), 0u);
  EXPECT_EQ(top.at("most").whole(18446744073709551615u), 18446744073709551615u);
  EXPECT_THROW(top.at("most").integer(INT64_MIN, INT64_MAX), FormatError);
  EXPECT_THROW(top.at("least").whole(3, 1), FormatError);
  EXPECT_THROW(top.at("half").whole(3), FormatError);
  EXPECT_EQ(top.at("large").number(), 1e39);
  EXPECT_THROW(top.at("large").smallNumber(), FormatError) << "beyond the range of a float";
}

TEST(JsonElement, ProposesTheNearestKeyOrListsAll) {
  const nlohmann::json value = {{"tolerance", 1}};
  const JsonElement top(value, "", kSource);
  EXPECT_EQ(messageOf([&] {
              top.onlyKeys({"tolerance_mm", "mesh"});
            }),
            "mouth.scene.json: the text has the unknown key \"tolerance\"; the nearest known one is \"tolerance_mm\".");
  EXPECT_EQ(messageOf([&] {
              top.onlyKeys({"mesh", "part"});
            }),
            "mouth.scene.json: the text has the unknown key \"tolerance\"; known are mesh, part.");
  EXPECT_EQ(messageOf([&] { top.onlyKeys({"mesh", "tolerance"}); }), "no error");
}

}  // namespace
}  // namespace spheretree::formats
