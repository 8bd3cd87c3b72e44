// SPDX-License-Identifier: Apache-2.0
#include "spheretree/formats/obj.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "spheretree/formats/errors.h"
#include "support/mesh_measures.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using test::areaOf;
using test::charsOf;
using test::volumeOf;

const std::string kTetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

MeshFile readObjText(std::string_view text, double unit_mm = 1) { return readObj(charsOf(text), "test.obj", unit_mm); }

std::string objRefusal(std::string_view text) {
  return test::refusalOf<FormatError>([&] { readObjText(text); });
}

testing::AssertionResult says(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words)
    if (text.find(word) == std::string::npos) return testing::AssertionFailure() << '"' << text << "\" lacks \"" << word << '"';
  return testing::AssertionSuccess();
}

TEST(Obj, ReadsATetrahedronExactly) {
  const MeshFile file = readObjText(kTetrahedron);
  ASSERT_EQ(file.mesh.positions.size(), 4u);
  EXPECT_EQ(file.mesh.positions[2], Eigen::Vector3d(0, 1, 0));
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}));
  EXPECT_DOUBLE_EQ(volumeOf(file.mesh), 1.0 / 6);
  EXPECT_TRUE(file.mesh.part.empty());
  EXPECT_TRUE(file.notes.empty());
  EXPECT_EQ(file.format, "OBJ");
}

TEST(Obj, TheUnitScalesEveryCoordinate) {
  const MeshFile file = readObjText(kTetrahedron, 25.4);
  EXPECT_EQ(file.mesh.positions[3], Eigen::Vector3d(0, 0, 25.4));
  EXPECT_EQ(file.unit_mm, 25.4);
  for (const double unit : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(readObjText(kTetrahedron, unit), std::invalid_argument) << unit;
}

TEST(Obj, KeepsAllDigitsOfADouble) {
  const MeshFile file = readObjText("v 0.1 -3000000.123456789 5e-324\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_EQ(file.mesh.positions[0], Eigen::Vector3d(0.1, -3000000.123456789, 5e-324));
}

TEST(Obj, WaysOfWritingTheSameMeshGiveTheSameMesh) {
  const TriangleMesh expected = readObjText(kTetrahedron).mesh;
  const auto replaced = [](std::string text, const std::string& from, const std::string& to) {
    for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) text.replace(at, from.size(), to);
    return text;
  };
  const std::string variants[] = {
      replaced(kTetrahedron, "\n", "\r\n"),
      replaced(kTetrahedron, "\n", "\r"),
      replaced(kTetrahedron, " ", " \t "),
      replaced(kTetrahedron, "\n", " # a comment\n"),
      "\xef\xbb\xbf" + kTetrahedron,
      kTetrahedron.substr(0, kTetrahedron.size() - 1),
      replaced(kTetrahedron, "v 1 0 0", "v +1.0 0e0 -0. 0.5 0.5 nan"),              // weights and colours follow
      "# C:\\models\\\n" + replaced(kTetrahedron, "f 1 3 2", "f 1 \\\n3 \\\r\n2"),  // continued lines, except in a comment
      replaced(replaced(kTetrahedron, "f 1 3 2", "f 1/1 3/7/2 2//9"), "f 2 3 4", "fo 2// 3 4"),
      "vn 0 0 1\nvt 0 0\nmtllib a.mtl\nusemtl x\ns off\n" + kTetrahedron + "l 1 2\np 1\n",
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -1 -2\nv 0 0 1\nf 1 2 -1\nf 1 4 3\nf 2 3 4",  // negative: counted backwards
      replaced(kTetrahedron, "v 0 0 0", "v 0 0 -0.0"),
  };
  for (const std::string& text : variants) {
    const TriangleMesh mesh = readObjText(text).mesh;
    EXPECT_EQ(mesh.positions, expected.positions) << text;
    EXPECT_EQ(mesh.triangles, expected.triangles) << text;
  }
}

TEST(Obj, AFaceMayComeBeforeItsVertices) {
  const MeshFile file = readObjText("f 1 2 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n");
  EXPECT_EQ(file.mesh.triangles.size(), 2u);
  EXPECT_DOUBLE_EQ(areaOf(file.mesh), 1);
}

TEST(Obj, GroupsAndObjectsNameParts) {
  const MeshFile file = readObjText(
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\ng crown of 11\nf 1 2 4\no root#1 # comment\nf 1 3 4\ng crown of 11\nf 2 3 4\n");
  EXPECT_EQ(file.mesh.part_names, (std::vector<std::string>{"", "crown of 11", "root#1_crown of 11"}));
  EXPECT_EQ(file.mesh.part, (std::vector<std::uint32_t>{0, 1, 2, 2}));
}

/// Of a file with one face after each line of statements.
std::vector<std::string> partNamesOf(const std::vector<std::string>& statements) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  for (const std::string& each : statements) text += each + "f 1 2 3\n";
  return readObjText(text).mesh.part_names;
}

TEST(Obj, APartIsAnObjectAndAGroup) {
  using Names = std::vector<std::string>;
  const Names teeth{"tooth_11", "tooth_21"};
  EXPECT_EQ(partNamesOf({"o tooth_11\ng enamel\n", "o tooth_21\ng enamel\n"}), teeth) << "one group name: named by the object";
  EXPECT_EQ(partNamesOf({"g tooth_11\no mesh\n", "g tooth_21\no mesh\n"}), teeth) << "one object name: named by the group";
  EXPECT_EQ(partNamesOf({"o tooth_11\n", "o tooth_21\n"}), teeth);
  EXPECT_EQ(partNamesOf({"o 11\ng crown\n", "g root\n", "o 21\ng crown\n", "g root\n", "o 11\ng crown\n"}),
            (Names{"11_crown", "11_root", "21_crown", "21_root"}));
}

TEST(Obj, MaterialsAreThePartsOfAFileThatIsDividedByNothingElse) {
  using Names = std::vector<std::string>;
  EXPECT_EQ(partNamesOf({"usemtl gum\n", "usemtl tooth_11\n", "usemtl gum\n"}), (Names{"gum", "tooth_11"}));
  EXPECT_EQ(partNamesOf({"o mouth\nusemtl gum\n", "usemtl tooth_11\n"}), (Names{"gum", "tooth_11"}));
  EXPECT_EQ(partNamesOf({"o a\nusemtl gum\n", "usemtl tooth\n", "o b\n"}), (Names{"a", "b"})) << "objects divide it already";
  EXPECT_EQ(partNamesOf({"o a\nusemtl gum\n"}), Names{"a"});
  EXPECT_EQ(partNamesOf({"usemtl gum\n"}), Names{}) << "one material divides nothing";
}

TEST(Obj, TakesTheBytesThatOldProgramsPutAtTheEnd) {
  const TriangleMesh expected = readObjText(kTetrahedron).mesh;
  for (const std::string& end : {std::string(1, '\0'), std::string(5, '\0'), std::string("\x1a"), std::string("\n\0\0", 3)}) {
    EXPECT_EQ(readObjText(kTetrahedron + end).mesh.triangles, expected.triangles);
    EXPECT_EQ(readObjText(kTetrahedron.substr(0, kTetrahedron.size() - 1) + end).mesh.triangles, expected.triangles) << "no line end";
  }
  EXPECT_TRUE(says(objRefusal(kTetrahedron + std::string("\0v\n", 3)), {"line 9", "zero byte"}));
}

TEST(Obj, ANumberTooSmallForDoublePrecisionIsZero) {
  for (const char* tiny :
       {"1e-400", "-3.5E-0999", "0.000e-400", "0.0001e-9999999999999999999", "12345e-500", "1e-99999999999999999999999"}) {
    const MeshFile file = readObjText(std::string("v ") + tiny + " 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    EXPECT_EQ(file.mesh.positions[0], Eigen::Vector3d(0, 0, 0)) << tiny;
  }
  for (const char* huge : {"1e400", "-1E+400", "0.001e900", "1e99999999999999999999999"})
    EXPECT_TRUE(says(objRefusal(std::string("v ") + huge + " 0 0\n"), {"range", huge}));
}

TEST(Obj, AVertexThatNoFaceUsesMayBeNoPoint) {
  const MeshFile file = readObjText(kTetrahedron + "v nan nan nan\nv 1.#QNAN -1.#IND00 1.#INF\nv inf 0 0\n");
  EXPECT_EQ(file.mesh.triangles, readObjText(kTetrahedron).mesh.triangles);
  EXPECT_EQ(file.vertex_of_file[4], kNone);
  ASSERT_EQ(file.notes.size(), 2u);
  EXPECT_TRUE(says(file.notes[0], {"vertices", "no face uses"}));
  EXPECT_EQ(file.notes[1], "3 of them are not at a finite point.");
}

TEST(Obj, WeldsEqualPlacesAndDropsUnusedVertices) {
  const MeshFile file = readObjText("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 -0 0\nv 1 0 0\nv 0 0 1\nf 2 3 4\nf 5 7 6\n");
  EXPECT_EQ(file.mesh.positions.size(), 4u);
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 3, 1}}));
  ASSERT_EQ(file.notes.size(), 1u);
  EXPECT_TRUE(says(file.notes[0], {"1 vertex", "no face uses"}));
}

TEST(Obj, CutsConvexPolygonsIntoAFanFromTheFirstCorner) {
  const MeshFile file = readObjText("v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0.1\nv 0 2 0\nf 1 2 3 4 5\n");  // not quite flat
  EXPECT_EQ(file.mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}}));
}

/// Corners of a polygon in a tilted plane, and its area.
struct Polygon {
  std::vector<std::array<double, 2>> corners;
  double area = 0;
};

TEST(Obj, ConcavePolygonsAreCoveredExactlyOnce) {
  std::vector<Polygon> polygons = {
      {{{0, 0}, {4, 0}, {4, 4}, {2, 1}}},
      {{{2, 1}, {0, 0}, {4, 0}, {4, 4}}},
      {{{0, 0}, {6, 0}, {6, 1}, {1, 1}, {1, 3}, {6, 3}, {6, 4}, {0, 4}}},  // C
      {{{0, 0}, {1, 3}, {2, 0}, {3, 3}, {4, 0}, {4, 5}, {0, 5}}},          // crown
  };
  Polygon star;
  for (int i = 0; i < 40; ++i) {
    const double r = i % 2 ? 1 : 5, angle = i * std::acos(-1.0) / 20;
    star.corners.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  polygons.push_back(star);
  for (Polygon& polygon : polygons) {
    const std::size_t n = polygon.corners.size();
    for (std::size_t i = 0; i < n; ++i) {
      const auto &a = polygon.corners[i], &b = polygon.corners[(i + 1) % n];
      polygon.area += (a[0] * b[1] - a[1] * b[0]) / 2;
    }
    for (std::size_t shift = 0; shift < n; ++shift) {
      for (const bool is_mirrored : {false, true}) {
        std::string text, face = "f";
        for (std::size_t i = 0; i < n; ++i) {
          const auto& c = polygon.corners[(i + shift) % n];
          const double x = is_mirrored ? -c[0] : c[0], y = c[1];  // the plane z = x + y / 2
          text += "v " + std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(x + y / 2) + "\n";
          face.append(" ").append(std::to_string(i + 1));
        }
        const MeshFile file = readObjText(text + face + "\n");
        ASSERT_EQ(file.mesh.triangles.size(), n - 2);
        double signed_area = 0, area = 0;  // seen along z
        for (std::size_t t = 0; t < n - 2; ++t) {
          const Eigen::Vector3d normal =
              (file.mesh.corner(t, 1) - file.mesh.corner(t, 0)).cross(file.mesh.corner(t, 2) - file.mesh.corner(t, 0));
          signed_area += normal.z() / 2;
          area += std::abs(normal.z()) / 2;
        }
        const double expected = std::abs(polygon.area);
        EXPECT_NEAR(area, expected, 1e-4 * expected) << "corners " << n << ", from " << shift;
        EXPECT_NEAR(signed_area, is_mirrored ? -polygon.area : polygon.area, 1e-4 * expected);
      }
    }
  }
}

TEST(Obj, PolygonsThatCrossThemselvesOrVanishStillEndInTriangles) {
  EXPECT_EQ(readObjText("v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n").mesh.triangles.size(), 2u);
  EXPECT_EQ(readObjText("v 0 0 0\nv 1 1 0\nf 1 2 1 2 1\n").mesh.triangles.size(), 3u);
  EXPECT_EQ(readObjText("v 0 0 0\nv 1e308 0 0\nv 1e308 1e308 0\nv -1e308 1e308 0\nf 1 2 3 4\n").mesh.triangles.size(), 2u);
}

TEST(Obj, RefusalsNameTheLineAndTheValue) {
  const std::string corner = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_TRUE(says(objRefusal(corner + "f 1 2 4\n"), {"test.obj", "line 4", "face 1", "vertex 4", "3 vertices"}));
  EXPECT_TRUE(says(objRefusal(corner + "f 1 2 3\nf 1 0 3\n"), {"line 5", "face 2", "vertex 0", "from 1"}));
  EXPECT_TRUE(says(objRefusal(corner + "f 1 2 -4\n"), {"line 4", "-4"}));
  EXPECT_TRUE(says(objRefusal(corner + "f 1 2 99999999999999999999\n"), {"line 4", "99999999999999999999"}));
  EXPECT_TRUE(says(objRefusal(corner + "f 1 2 4294967297\n"), {"line 4", "4294967297"}));
  EXPECT_TRUE(says(objRefusal(corner + "f 1 x 3\n"), {"line 4", "\"x\""}));
  EXPECT_TRUE(says(objRefusal(corner + "v 0 nan 0\nf 1 2 4\n"), {"line 4", "vertex 3", "(0, nan, 0)", "a face uses it"}));
  EXPECT_TRUE(says(objRefusal("\n\nv 0 -inf 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), {"line 3", "-inf"}));
  EXPECT_TRUE(says(objRefusal("v 0 1e999 0\n"), {"line 1", "1e999", "range"}));
  EXPECT_TRUE(says(objRefusal("v 0 1,5 0\n"), {"line 1", "1,5", "decimal point"}));
  EXPECT_TRUE(says(objRefusal("v 0 3.1+e2 0\n"), {"line 1", "3.1+e2"}));
  EXPECT_TRUE(says(objRefusal("v 0 1\n"), {"line 1", "three coordinates"}));
  EXPECT_TRUE(says(objRefusal(corner), {"no triangle"}));
  EXPECT_TRUE(says(objRefusal(corner + "f 1 2\nl 1 2 3\n"), {"no triangle", "fewer than three"}));
  EXPECT_TRUE(says(objRefusal(""), {"no triangle"}));
  EXPECT_TRUE(says(objRefusal("\xff\xfev"), {"UTF-16"}));
  EXPECT_TRUE(says(objRefusal(std::string_view("\0v\0 ", 4)), {"UTF-16"}));
  EXPECT_TRUE(says(test::refusalOf<FormatError>([] { readObjText("v 1e300 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", 1e10); }),
                   {"line 1", "smaller unit"}));
}

TEST(Obj, ALargeConcavePolygonIsRefusedRatherThanCutForHours) {
  std::string text, face = "f";
  for (int i = 0; i < 5000; ++i) {
    text += "v " + std::to_string(i) + " " + std::to_string(i % 2 ? i * i : 0) + " 0\n";
    face.append(" ").append(std::to_string(i + 1));
  }
  EXPECT_TRUE(says(objRefusal(text + face + "\n"), {"5000 corners", "4096"}));
}

}  // namespace
}  // namespace spheretree::formats
