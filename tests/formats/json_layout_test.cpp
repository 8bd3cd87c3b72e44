// SPDX-License-Identifier: Apache-2.0
#include "text/json_layout.h"

#include <gtest/gtest.h>

#include <string>

#include "support/random.h"

namespace spheretree::formats {
namespace {

using LaidOut = nlohmann::ordered_json;

LaidOut randomValue(test::Random& random, int depth) {
  switch (depth > 3 ? random.below(3) : random.below(5)) {
    case 0:
      return random.between(-1000, 1000);
    case 1:
      return std::string(random.below(30), 'x') + "\"\\";
    case 2:
      return random.below(2) == 0;
    case 3: {
      LaidOut list = LaidOut::array();
      for (std::uint64_t n = random.below(20); n > 0; --n) list.push_back(randomValue(random, depth + 1));
      return list;
    }
    default: {
      LaidOut object = LaidOut::object();
      for (std::uint64_t n = random.below(8); n > 0; --n) object["key" + std::to_string(n)] = randomValue(random, depth + 1);
      return object;
    }
  }
}

TEST(JsonLayout, IsTheSameValue) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    test::Random random(seed);
    const LaidOut value = randomValue(random, 0);
    EXPECT_EQ(LaidOut::parse(layOut(value)), value) << seed;
  }
}

TEST(JsonLayout, PutsOneKeyOfTheTopAndOneElementOfALongListOnALine) {
  LaidOut scene{{"unit", "mm"}, {"objects", LaidOut::array()}};
  EXPECT_EQ(layOut(scene), "{\"unit\": \"mm\",\n \"objects\": []}");
  for (int i = 0; i < 12; ++i) scene["objects"].push_back({{"name", "tooth_" + std::to_string(i)}, {"mesh", "mouth.obj"}});
  const std::string text = layOut(scene);
  std::size_t lines = 1, begin = 0;
  for (std::size_t i = 0; i <= text.size(); ++i)
    if (i == text.size() || text[i] == '\n') {
      EXPECT_LE(i - begin, 120u);
      lines += i < text.size();
      begin = i + 1;
    }
  EXPECT_EQ(lines, 13u) << text;
}

TEST(JsonLayout, RefusesTextThatIsNotUtf8) { EXPECT_THROW(layOut(LaidOut{{"name", "\xff"}}), nlohmann::json::exception); }

}  // namespace
}  // namespace spheretree::formats
