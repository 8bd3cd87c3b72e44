// SPDX-License-Identifier: Apache-2.0
#include "text/content_kind.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace spheretree::formats {
namespace {

std::optional<MeshKind> kindOf(const std::string& text) { return meshKindOf({text.data(), text.size()}); }

std::string binaryStl(std::uint32_t triangles, std::size_t bytes_more = 0) {
  std::string text(84 + std::size_t{50} * triangles + bytes_more, '\0');
  for (std::size_t i = 0; i < 4; ++i) text[80 + i] = static_cast<char>(triangles >> (8 * i) & 0xff);
  return text;
}

TEST(ContentKind, KnowsEachFormatByItsFirstWords) {
  EXPECT_EQ(kindOf("# made by hand\n\nmtllib a.mtl\nv 0 0 0\n"), MeshKind::Obj);
  EXPECT_EQ(kindOf("o tooth\ng crown\nvn 0 0 1\n"), MeshKind::Obj);
  EXPECT_EQ(kindOf("solid tooth\n  facet normal 0 0 1\n"), MeshKind::Stl);
  EXPECT_EQ(kindOf("solid\nendsolid\n"), MeshKind::Stl);
  EXPECT_EQ(kindOf("ply\nformat ascii 1.0\n"), MeshKind::Ply);
  EXPECT_EQ(kindOf("ply\r\nformat ascii 1.0\r\n"), MeshKind::Ply);
  EXPECT_EQ(kindOf("OFF\n3 1 0\n"), MeshKind::Off);
  EXPECT_EQ(kindOf("STCN4OFF\n3 1 0\n"), MeshKind::Off);
  EXPECT_EQ(kindOf("\xef\xbb\xbf{\"asset\": {}}"), MeshKind::Gltf) << "a byte order mark is none of the text";
  EXPECT_EQ(kindOf("glTF\x02"), MeshKind::Gltf);
}

TEST(ContentKind, SaysNothingInDoubt) {
  EXPECT_EQ(kindOf(""), std::nullopt);
  EXPECT_EQ(kindOf("solid tooth\nv 0 0 0\n"), std::nullopt) << "many a binary STL begins with solid";
  EXPECT_EQ(kindOf("hello\n"), std::nullopt);
  EXPECT_EQ(kindOf("BOFF\n"), std::nullopt);
  EXPECT_EQ(kindOf(std::string("v 0 0\0 0", 8)), std::nullopt) << "a zero byte stands in no text";
  EXPECT_EQ(kindOf(binaryStl(1)), std::nullopt);
}

TEST(ContentKind, BinaryStlIsKnownByItsSizeAlone) {
  for (const std::uint32_t triangles : {0u, 1u, 257u}) {
    const std::string exact = binaryStl(triangles), longer = binaryStl(triangles, 1);
    EXPECT_TRUE(hasSizeOfBinaryStl({exact.data(), exact.size()})) << triangles;
    EXPECT_FALSE(hasSizeOfBinaryStl({longer.data(), longer.size()})) << triangles;
    EXPECT_FALSE(hasSizeOfBinaryStl({exact.data(), exact.size() - 1})) << triangles;
  }
  std::string largest = binaryStl(0);
  for (std::size_t i = 80; i < 84; ++i) largest[i] = '\xff';  // 2^32 - 1 triangles: their size must not wrap round
  EXPECT_FALSE(hasSizeOfBinaryStl({largest.data(), largest.size()}));
}

TEST(ContentKind, IsDescribedForMessages) {
  EXPECT_EQ(describedContent(""), "empty");
  EXPECT_EQ(describedContent("\x89STREE..."), "a sphere-tree (.stree)");
  EXPECT_EQ(describedContent("\x89PNG..."), "a picture (PNG)");
  EXPECT_EQ(describedContent("v 0 0 0\n"), "a mesh (OBJ)");
  EXPECT_EQ(describedContent("glTF...."), "a mesh (glTF)");
  EXPECT_EQ(describedContent(binaryStl(2)), "a mesh (STL)");
  EXPECT_EQ(describedContent(" \n[1, 2]"), "JSON");
  EXPECT_EQ(describedContent("{\"schema\": 1}"), "JSON") << "a scene is JSON as well as a glTF without a container";
  EXPECT_EQ(describedContent("a,b,c,d,e,f,g\n1,2,3,4,5,6,7\n"), "a table (CSV)");
  EXPECT_EQ(describedContent("a,b\n"), "");
}

TEST(ContentKind, EveryKindHasAName) {
  EXPECT_STREQ(nameOf(MeshKind::Obj), "OBJ");
  EXPECT_STREQ(nameOf(MeshKind::Stl), "STL");
  EXPECT_STREQ(nameOf(MeshKind::Ply), "PLY");
  EXPECT_STREQ(nameOf(MeshKind::Off), "OFF");
  EXPECT_STREQ(nameOf(MeshKind::Gltf), "glTF");
}

}  // namespace
}  // namespace spheretree::formats
