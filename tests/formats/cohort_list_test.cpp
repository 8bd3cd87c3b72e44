// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/cohort_list.h"

#include <gtest/gtest.h>

#include <array>

#include "spheretree/formats/errors.h"
#include "support/random.h"

namespace spheretree::formats {
namespace {

constexpr const char* kTwo = "{\"patient\": \"P.1-a_b\", \"scene\": \"a/mouth.scene.json\"}\r\n\n  {\"scene\": \"/b\", \"patient\": \"2\"}";

std::string refusalOfList(const std::string& text) {
  try {
    (void)parseCohortList(text, "l.jsonl");
  } catch (const FormatError& error) {
    return error.what();
  }
  return "";
}

TEST(CohortList, ReadsALineForEachPatient) {
  const std::vector<CohortPatient> patients = parseCohortList(kTwo, "l.jsonl");
  ASSERT_EQ(patients.size(), 2u);
  EXPECT_EQ(patients[0].name, "P.1-a_b");
  EXPECT_EQ(patients[0].scene, "a/mouth.scene.json");
  EXPECT_EQ(patients[1].name, "2");
}

TEST(CohortList, RefusesWithTheLine) {
  const std::string good = "{\"patient\": \"a\", \"scene\": \"s\"}\n";
  const std::vector<std::array<std::string, 2>> cases{{"", "names no patient"},
                                                      {"\n \n", "names no patient"},
                                                      {good + "nonsense", "line 2"},
                                                      {good + "[]", "line 2: the text is not an object"},
                                                      {good + "{\"patient\": \"b\"}", "line 2: the text has no \"scene\""},
                                                      {good + "{\"patient\": \"b\", \"scene\": \"\"}", "line 2: scene is empty"},
                                                      {good + "{\"patient\": 3, \"scene\": \"s\"}", "line 2: patient is not"},
                                                      {"{\"patient\": \"b\", \"scene\": \"s\", \"work\": 1}", "unknown key \"work\""},
                                                      {"{\"patient\": \"../b\", \"scene\": \"s\"}", "cannot name a folder"},
                                                      {"{\"patient\": \"a/b\", \"scene\": \"s\"}", "cannot name a folder"},
                                                      {"{\"patient\": \".b\", \"scene\": \"s\"}", "cannot name a folder"},
                                                      {"{\"patient\": \"\", \"scene\": \"s\"}", "cannot name a folder"},
                                                      {"{\"patient\": \"Cache\", \"scene\": \"s\"}", "cannot name a folder"},
                                                      {"{\"patient\": \"" + std::string(101, 'x') + "\", \"scene\": \"s\"}", "cannot name"},
                                                      {good + "\n{\"patient\": \"A\", \"scene\": \"s\"}", "is in line 1 already"}};
  for (const auto& [text, place] : cases)
    EXPECT_NE(refusalOfList(text).find(place), std::string::npos) << text << ": " << refusalOfList(text);
}

TEST(CohortList, ReadsOrRefusesAnyDamage) {
  test::Random random(3);
  std::size_t refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string text = kTwo;
    const std::size_t at = random.below(text.size());
    if (i % 3 == 0)
      text.resize(at);
    else
      text[at] = static_cast<char>(random.between(1, 255));
    refused += !refusalOfList(text).empty();  // and no other exception
  }
  EXPECT_GT(refused, 100u);
}

}  // namespace
}  // namespace spheretree::formats
