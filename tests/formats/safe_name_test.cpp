// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/safe_name.h"

#include <gtest/gtest.h>

namespace spheretree::formats {
namespace {

TEST(SafeName, KeepsLettersOfEveryScript) {
  for (const char* name : {"tooth_16", "上颌", "牙齿16", "Müller-upperjaw", "Mu\xcc\x88ller", "зуб.2", "歯", "𠀋"}) {
    EXPECT_TRUE(isSafeName(name)) << name;
    EXPECT_EQ(safeName(name), name);
  }
}

TEST(SafeName, ReplacesWhatAFileSystemOrAReaderTakesAmiss) {
  for (const char* bad : {"", "-a", ".a", "a b", "a/b", "a\\b", "a\nb", "a\xc2\x85", "a\xc2\xa0", "\xe2\x80\xae", "\xe3\x80\x80",
                          "\xef\xbb\xbf", "\xff", "\xc0\xaf", "\xed\xa0\x80", "\xee\x80\x80"})
    EXPECT_FALSE(isSafeName(bad)) << bad;
  EXPECT_EQ(safeName("Zahn 11"), "Zahn_11");
  EXPECT_EQ(safeName("../x"), "_x");
  EXPECT_EQ(safeName("上 颌\xe2\x80\xae"), "上_颌_");
  EXPECT_EQ(safeName(" "), "part");
  EXPECT_EQ(safeName("M\xfcller"), "Müller") << "Latin-1";
  EXPECT_NE(safeName("\xc9\xcf"), safeName("\xcf\xc2")) << "names of another encoding can be told apart";
}

TEST(SafeName, IsCutAtAWholeCharacter) {
  std::string wanted;
  for (int i = 0; i < 30; ++i) wanted += "颌";  // 3 bytes
  EXPECT_EQ(safeName(wanted).size(), 63u);
  EXPECT_TRUE(isSafeName(safeName(wanted)));
  EXPECT_FALSE(isSafeName(wanted));
  EXPECT_EQ(cutName("a颌", 3), "a");
  EXPECT_EQ(cutName("a颌", 4), "a颌");
}

}  // namespace
}  // namespace spheretree::formats
