// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/ply.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>

#include "spheretree/formats/errors.h"
#include "support/mesh_measures.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::has;

MeshFile readPlyText(std::string_view bytes) { return readPly(test::charsOf(bytes), "test.ply"); }

std::string plyRefusal(std::string_view bytes) {
  return test::refusalOf<FormatError>([&] { readPlyText(bytes); });
}

const std::string kAscii =
    "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\n"
    "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";

/// The tetrahedron in binary form, with coordinates, list counts and indices of any type.
class Writer {
 public:
  explicit Writer(bool is_big, std::string line_end = "\n") : is_big_(is_big), line_end_(std::move(line_end)) {}
  template <class T>
  void put(double value) {
    const T number = static_cast<T>(value);
    const auto* first = reinterpret_cast<const char*>(&number);
    std::string bytes(first, sizeof number);
    if (is_big_ != (std::endian::native == std::endian::big)) std::reverse(bytes.begin(), bytes.end());
    body_ += bytes;
  }
  template <class Coordinate, class Count, class Index>
  std::string write(const char* coordinate, const char* count, const char* index) {
    const double places[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const int faces[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    for (const auto& p : places) {
      put<std::uint8_t>(7);  // colour, before x
      put<Coordinate>(p[2]);
      put<Coordinate>(p[1]);
      put<std::uint16_t>(2);  // a list between the coordinates
      put<float>(1), put<float>(2);
      put<Coordinate>(p[0]);
    }
    put<std::int32_t>(5), put<std::int8_t>(-1);  // another element
    for (const auto& f : faces) {
      put<std::uint8_t>(1), put<double>(0.5);
      put<Count>(3);
      for (const int i : f) put<Index>(i);
      put<std::int16_t>(-3);
    }
    const std::string c = coordinate;
    std::string header;
    for (const std::string& line :
         {std::string("ply"), std::string("format binary_") + (is_big_ ? "big" : "little") + "_endian 1.0",
          std::string("comment end_header"), std::string("element vertex 4"), std::string("property uchar red"), "property " + c + " z",
          "property " + c + " y", std::string("property list ushort float weights"), "property " + c + " x",
          std::string("element camera 1"), std::string("property int32 a"), std::string("property int8 b"), std::string("element face 4"),
          std::string("property list uint8 float64 texcoord"), std::string("property list ") + count + " " + index + " vertex_index",
          std::string("property int16 flags"), std::string("end_header")})
      header += line + line_end_;
    return header + body_;
  }

 private:
  bool is_big_;
  std::string line_end_, body_;
};

TEST(Ply, AllEncodingsAndTypesGiveTheSameMesh) {
  const TriangleMesh expected = readPlyText(kAscii).mesh;
  EXPECT_DOUBLE_EQ(test::volumeOf(expected), 1.0 / 6);
  const auto expectSame = [&](const std::string& bytes, const char* what) {
    const TriangleMesh mesh = readPlyText(bytes).mesh;
    EXPECT_EQ(mesh.positions, expected.positions) << what;
    EXPECT_EQ(mesh.triangles, expected.triangles) << what;
  };
  for (const bool is_big : {false, true}) {
    for (const char* line_end : {"\n", "\r\n", "\r"}) {
      const auto writer = [&] { return Writer(is_big, line_end); };
      expectSame(writer().write<double, std::uint8_t, std::int32_t>("double", "uchar", "int"), "usual");
      expectSame(writer().write<float, std::uint16_t, std::uint32_t>("float", "ushort", "uint"), "ushort");
      expectSame(writer().write<std::int8_t, std::int32_t, std::uint8_t>("char", "int", "uchar"), "char");
      expectSame(writer().write<std::uint16_t, std::int8_t, std::int16_t>("uint16", "int8", "int16"), "short");
      expectSame(writer().write<std::int32_t, std::uint32_t, std::int8_t>("int32", "uint32", "int8"), "int32");
    }
  }
}

TEST(Ply, AsciiRowsGoByLines) {
  std::string text = kAscii;
  text.replace(text.find("3 0 2 1\n"), 8, "3 0 2 1 9 9 9\n\n");
  const MeshFile file = readPlyText(text);
  EXPECT_EQ(file.mesh.triangles.size(), 4u);
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_TRUE(has(file.notes[0], "1 line holds more values"));
  std::string short_row = kAscii;
  short_row.replace(short_row.find("0 1 0\n"), 6, "0 1\n");
  EXPECT_TRUE(has(plyRefusal(short_row), "line 13: vertex 2 has fewer values")) << plyRefusal(short_row);
}

TEST(Ply, EveryTruncationIsRefused) {
  for (const std::string& whole : {kAscii, Writer(false).write<double, std::uint8_t, std::int32_t>("double", "uchar", "int"),
                                   Writer(true, "\r\n").write<float, std::uint16_t, std::uint32_t>("float", "ushort", "uint")}) {
    const std::size_t spare = whole == kAscii ? 2 : 0;  // the last digit and its line end
    for (std::size_t size = 0; size + spare < whole.size(); ++size) {
      const std::vector<char> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_THROW(readPly(cut, "test.ply"), FormatError) << size;
    }
  }
}

TEST(Ply, PointsThatNoFaceUsesMayBeNan) {
  const std::string text = test::replaced(test::replaced(kAscii, "vertex 4", "vertex 5"), "0 0 1\n", "0 0 1\n-nan(ind) nan 1\n");
  const MeshFile file = readPlyText(text);
  EXPECT_DOUBLE_EQ(test::volumeOf(file.mesh), 1.0 / 6);
  EXPECT_EQ(file.vertex_of_file.size(), 5u) << "labels of the vertices still fit";
  EXPECT_EQ(file.notes.back(), "1 of them is not at a finite point.");
}

TEST(Ply, RefusalsNameTheElementAndTheValue) {
  const auto with = [](const std::string& from, const std::string& to) {
    std::string text = kAscii;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_TRUE(has(plyRefusal(with("3 0 2 1\n", "3 0 2 4\n")), "face 0 names vertex 4, but there are 4"));
  EXPECT_TRUE(has(plyRefusal(with("3 0 2 1\n", "3 0 2 -1\n")), "vertex -1"));
  EXPECT_TRUE(has(plyRefusal(with("3 0 2 1\n", "-3 0 2 1\n")), "of -3 values"));
  EXPECT_TRUE(has(plyRefusal(with("1 0 0\n", "nan 0 0\n")), "line 12: vertex 1, counted from 0, at (nan, 0, 0)"));
  EXPECT_TRUE(has(plyRefusal(with("vertex 4", "vertex 99999999999")), "99999999999 rows of \"vertex\""));
  EXPECT_TRUE(has(plyRefusal(with("face 4", "face 1844674407370955161")), "1844674407370955161"));
  EXPECT_TRUE(has(plyRefusal(with("property double y", "property quad y")), "\"quad\""));
  EXPECT_TRUE(has(plyRefusal(with("list uchar int", "list float int")), "\"float\" cannot count"));
  EXPECT_TRUE(has(plyRefusal(with("list uchar int", "list uchar float")), "whole numbers"));
  EXPECT_TRUE(has(plyRefusal(with("format ascii 1.0", "format ascii 2.0")), "\"2.0\""));
  EXPECT_TRUE(has(plyRefusal(with("format ascii 1.0", "format text 1.0")), "\"text\""));
  EXPECT_TRUE(has(plyRefusal(with("double z", "double w")), "no property \"z\""));
  EXPECT_TRUE(has(plyRefusal(with("element face", "element fans")), "no element \"face\""));
  EXPECT_TRUE(has(plyRefusal(with("ply", "plx")), "\"ply\""));
  std::string bytes = Writer(false).write<double, std::uint8_t, std::int32_t>("double", "uchar", "int");
  const double infinity = std::numeric_limits<double>::infinity();
  const std::size_t row = 1 + 3 * 8 + 2 + 8, body = bytes.size() - 4 * row - 5 - 4 * (1 + 8 + 1 + 12 + 2);
  bytes.replace(body + 2 * row + 1, 8, reinterpret_cast<const char*>(&infinity), 8);
  EXPECT_TRUE(has(plyRefusal(bytes), "vertex 2, counted from 0, at (0, 1, inf)")) << plyRefusal(bytes);
}

}  // namespace
}  // namespace spheretree::formats
