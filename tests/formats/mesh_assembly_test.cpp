// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_assembly.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "spheretree/formats/errors.h"
#include "support/random.h"
#include "support/texts.h"

namespace spheretree::formats {
namespace {

using Eigen::Vector3d;

MeshAssembly inMm() { return {"a.obj", 1}; }

/// Adds a polygon with these corners.
void addCorners(MeshAssembly& assembly, const std::vector<Vector3d>& corners) {
  std::vector<std::uint32_t> index;
  for (const Vector3d& p : corners) {
    index.push_back(assembly.vertexCount());
    ASSERT_TRUE(assembly.addVertex(p.x(), p.y(), p.z()));
  }
  assembly.addPolygon(index);
}

/// A star about the origin, counterclockwise in the plane z = 0; convex if all radii are 1.
std::vector<Vector3d> starOf(std::size_t corners, test::Random& random, double smallest) {
  std::vector<Vector3d> star;
  for (std::size_t i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(corners), r = random.between(smallest, 1);
    star.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
  }
  return star;
}

// A triangulation of a simple polygon: its triangles face the same way, and their areas add up to that of the polygon.
TEST(MeshAssembly, CutsEverySimplePolygonIntoTrianglesOfItsOwnArea) {
  test::Random random(5);
  for (int n = 0; n < 200; ++n) {
    const std::vector<Vector3d> flat = starOf(4 + random.below(40), random, n % 4 == 0 ? 1 : 0.1);
    const Eigen::Quaterniond turn = Eigen::Quaterniond(random.unit(), random.between(-1, 1), random.between(-1, 1), 0.1).normalized();
    double area = 0;
    for (std::size_t i = 0; i < flat.size(); ++i) area += flat[i].cross(flat[(i + 1) % flat.size()]).z() / 2;
    std::vector<Vector3d> corners;
    for (const Vector3d& p : flat) corners.push_back(1e3 * (turn * p) + Vector3d(7, -8, 9));
    MeshAssembly assembly = inMm();
    addCorners(assembly, corners);
    const MeshFile file = assembly.finish("OBJ");
    ASSERT_EQ(file.mesh.triangles.size(), flat.size() - 2);
    double sum = 0;
    for (std::size_t t = 0; t < file.mesh.triangles.size(); ++t) {
      const Vector3d a = file.mesh.corner(t, 0), across = (file.mesh.corner(t, 1) - a).cross(file.mesh.corner(t, 2) - a);
      EXPECT_GT(across.dot(turn * Vector3d::UnitZ()), 0) << "polygon " << n << ", triangle " << t;
      sum += across.norm() / 2e6;
    }
    EXPECT_NEAR(sum, area, 1e-9) << "polygon " << n;
    EXPECT_EQ(file.notes, std::vector<std::string>{"1 polygon was cut into triangles; from here on faces are counted as triangles."});
  }
}

TEST(MeshAssembly, RefusesAConcavePolygonThatWouldTakeLongButNotAConvexOne) {
  test::Random random(6);
  for (const double smallest : {1.0, 0.5}) {
    MeshAssembly assembly = inMm();
    const std::string refusal = test::refusalOf<FormatError>([&] { addCorners(assembly, starOf(4097, random, smallest)); });
    EXPECT_EQ(refusal.empty(), smallest == 1);
    EXPECT_TRUE(smallest == 1 || test::has(refusal, "a.obj: a concave face has 4097 corners; at most 4096 are read.")) << refusal;
  }
}

TEST(MeshAssembly, TakesThreeCoordinatesInItsUnit) {
  MeshAssembly metres("a.ply", 1000);
  std::string_view text = " 1.5 -2e-3\t0.25 7 8";
  metres.takeVertex(text, 3);
  EXPECT_EQ(text, " 7 8");
  ASSERT_TRUE(metres.addVertex(-0.0, 1, 2) && metres.addVertex(0, 0, 0));
  metres.addTriangle(0, 1, 2);
  const MeshFile file = metres.finish("PLY");
  EXPECT_EQ(file.mesh.positions[0], Vector3d(1500, -2, 250));
  EXPECT_FALSE(std::signbit(file.mesh.positions[1].x())) << "equal positions have equal bits";
  EXPECT_EQ(file.unit_mm, 1000);
  EXPECT_EQ(file.format, "PLY");
  EXPECT_FALSE(metres.addVertex(std::numeric_limits<double>::infinity(), 0, 0));
  EXPECT_FALSE(metres.addVertex(0, 1e306, 0)) << "1e309 mm";
}

TEST(MeshAssembly, RefusesBadCoordinatesWithTheirLine) {
  const std::vector<std::pair<std::string, std::string>> cases{{"1 2", "line 7: a vertex needs three coordinates on its line."},
                                                               {"1 2,5 3", "line 7: \"2,5\" is not a number."},
                                                               {"1 2 1e400", "line 7: \"1e400\" is out of the range of double precision."}};
  for (const auto& [text, message] : cases) {
    MeshAssembly metres("a.ply", 1000);
    std::string_view rest = text;
    const std::string refusal = test::refusalOf<FormatError>([&] { metres.takeVertex(rest, 7); });
    EXPECT_TRUE(test::has(refusal, "a.ply: " + message)) << refusal;
    EXPECT_EQ(metres.vertexCount(), 0u);
  }
  for (const double unit : {0.0, -1.0, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(MeshAssembly("a.ply", unit), std::invalid_argument) << unit;
}

TEST(MeshAssembly, RefusesAVertexThatIsNotFiniteIfAFaceUsesIt) {
  for (const auto& [text, message] : std::vector<std::pair<std::string, std::string>>{
           {"nan 2 3", "a.ply: line 7: vertex 3, counted from 0, at (nan, 2, 3), is not finite in mm, and a face uses it."},
           {"1 -inf 3", "at (1, -inf, 3)"},
           {"1 2 1e306", "choose a smaller unit"}}) {
    MeshAssembly metres("a.ply", 1000);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(metres.addVertex(i, i * i, 0));
    metres.addTriangle(0, 1, 2);
    std::string_view rest = text;
    metres.takeVertex(rest, 7);
    EXPECT_EQ(MeshAssembly(metres).finish("PLY").vertex_of_file[3], kNone) << "no face uses it";
    metres.addTriangle(1, 2, 3);
    const std::string refusal = test::refusalOf<FormatError>([&] { (void)metres.finish("PLY"); });
    EXPECT_TRUE(test::has(refusal, message)) << refusal;
  }
}

TEST(MeshAssembly, APartGoesOnWhereItsNameComesAgain) {
  MeshAssembly assembly = inMm();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(assembly.addVertex(i, i * i, 0));
  for (const char* name : {"crown", "root", "never used", "crown"}) {
    assembly.beginPart(name);
    EXPECT_EQ(assembly.partName(), name);
    if (assembly.partName() != "never used") assembly.addTriangle(0, 1, 2);
  }
  const MeshFile file = assembly.finish("OBJ");
  EXPECT_EQ(file.mesh.part_names, (std::vector<std::string>{"crown", "root"}));
  EXPECT_EQ(file.mesh.part, (std::vector<std::uint32_t>{0, 1, 0}));
}

TEST(MeshAssembly, SaysWhatItLeftOutAndRefusesAFileWithoutTriangles) {
  const std::vector<std::uint32_t> two{0, 1}, three{0, 1, 2};
  MeshAssembly assembly = inMm();
  const auto refusal = [](MeshAssembly part) { return test::refusalOf<FormatError>([&] { (void)part.finish("OBJ"); }); };
  EXPECT_TRUE(test::has(refusal(assembly), "a.obj: has no triangle and no vertex. A solid needs faces"));
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(assembly.addVertex(i, i * i, 0));
  EXPECT_TRUE(test::has(refusal(assembly), "has no triangle, only vertices, lines or points."));
  assembly.addPolygon(two);
  EXPECT_TRUE(test::has(refusal(assembly), "has no triangle, only faces of fewer than three corners."));
  assembly.addPolygon(two);
  assembly.addPolygon(three);
  const MeshFile file = assembly.finish("OBJ");
  EXPECT_EQ(file.notes,
            (std::vector<std::string>{"2 faces of fewer than three corners left out.", "2 vertices that no face uses left out."}));
  EXPECT_TRUE(file.mesh.part_names.empty()) << "a single part without a name is none";
}

}  // namespace
}  // namespace spheretree::formats
