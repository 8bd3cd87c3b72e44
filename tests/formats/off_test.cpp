// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/off.h"

#include <gtest/gtest.h>

#include "spheretree/formats/errors.h"
#include "support/mesh_measures.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::has;

const std::string kBody = "4 4 6\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

MeshFile readOffText(std::string_view text) { return readOff(test::charsOf(text), "test.off"); }

std::string offRefusal(std::string_view text) {
  return test::refusalOf<FormatError>([&] { readOffText(text); });
}

TEST(Off, VariantsOfOneMeshGiveTheSameMesh) {
  const TriangleMesh expected = readOffText("OFF\n" + kBody).mesh;
  EXPECT_DOUBLE_EQ(test::volumeOf(expected), 1.0 / 6);
  const std::string variants[] = {
      kBody,
      "OFF" + kBody,
      "OFF 4 4 6 # counts\n" + kBody.substr(6),
      "# a comment\n\n  OFF\r\n" + kBody,
      "COFF\n4 4 6\n0 0 0 255 0 0 255\n1 0 0 1 1 1\n0 1 0\n0 0 1\n3 0 2 1 0.5 0.5 0.5\n3 0 1 3 7\n3 0 3 2\n3 1 2 3",
      "STCNOFF\n" + kBody,
      "\xef\xbb\xbfOFF\n" + kBody,
      "OFF\n4 4\n" + kBody.substr(6),
  };
  for (const std::string& text : variants) {
    const TriangleMesh mesh = readOffText(text).mesh;
    EXPECT_EQ(mesh.positions, expected.positions) << text;
    EXPECT_EQ(mesh.triangles, expected.triangles) << text;
  }
}

TEST(Off, WordsMayBeBrokenIntoLinesAnywhere) {
  const TriangleMesh expected = readOffText("OFF\n" + kBody).mesh;
  std::string one_each = "OFF\n", one_line = "OFF", pairs;
  std::size_t count = 0;
  std::string word;
  for (const char c : kBody) {
    if (c != ' ' && c != '\n') {
      word += c;
      continue;
    }
    one_each += word + "\n";
    one_line += " " + word;
    pairs += word + (++count % 2 ? " " : "\n");
    word.clear();
  }
  const std::string coloured =
      "CNOFF\n4 4 6\n0 0 0 0 0 1 255 0 0\n255 1 0 0 0 0 1 255 0 0 255\n0 1 0 0 0 1 255 0 0 255 0 0 1 0 0 1 255 0 0 255\n3 0 2 1 3 0 1 3\n3 "
      "0 3 2 "
      "3 1 2 3\n";
  for (const std::string& text : {one_each, one_line, "OFF\n" + pairs, coloured}) {
    const TriangleMesh mesh = readOffText(text).mesh;
    EXPECT_EQ(mesh.positions, expected.positions) << text;
    EXPECT_EQ(mesh.triangles, expected.triangles) << text;
  }
  EXPECT_TRUE(has(offRefusal(one_line + " 7"), "test.off")) << "a word too many";
}

TEST(Off, EveryTruncationIsRefused) {
  const std::string whole = "OFF\n" + kBody;
  for (std::size_t size = 0; size + 2 < whole.size(); ++size)  // without "3\n" the last index is missing
    EXPECT_THROW(readOffText(whole.substr(0, size)), FormatError) << size;
}

TEST(Off, RefusalsNameTheElementAndTheValue) {
  EXPECT_TRUE(has(offRefusal("OFF\n353535235358 6 0\n0 0 0\n"), "353535235358"));
  EXPECT_TRUE(has(offRefusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "face 0 names vertex \"3\"; valid are 0 to 2"));
  EXPECT_TRUE(has(offRefusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n"), "-1"));
  EXPECT_TRUE(has(offRefusal("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n9999999999 0 1 2\n"), "9999999999 corners, but its line has 3"));
  EXPECT_TRUE(has(offRefusal("OFF\n3 1 0\n0 0 0\n1 0\n0 1 0\n3 0 1 2\n"), "line 4: a vertex needs three"));
  EXPECT_TRUE(has(offRefusal("OFF\n3 1 0\n0 0 0\n1 0 x\n0 1 0\n3 0 1 2\n"), "line 4: \"x\""));
  EXPECT_TRUE(has(offRefusal("OFF\n-3 1 0\n"), "\"-3\""));
  EXPECT_TRUE(has(offRefusal("4OFF\n1 1 0\n"), "more than three"));
  EXPECT_TRUE(has(offRefusal("OFF BINARY\n"), "binary OFF"));
  EXPECT_TRUE(has(offRefusal("OFF\n1 0 0\n0 0 0\n"), "no triangle"));
  EXPECT_TRUE(has(offRefusal(""), "empty"));
}

}  // namespace
}  // namespace spheretree::formats
