// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/mesh_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "support/mesh_measures.h"
#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using test::boxMesh;
using test::joined;
using test::sphereMesh;
using test::torusMesh;
using test::volumeOf;

TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& by) {
  for (Eigen::Vector3d& p : mesh.positions) p += by;
  return mesh;
}

TriangleMesh flipped(TriangleMesh mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

std::set<DefectKind> kindsOf(const MeshReport& report) {
  std::set<DefectKind> kinds;
  for (const Defect& d : report.defects) kinds.insert(d.kind);
  return kinds;
}

using Kinds = std::set<DefectKind>;

TEST(MeshChecks, SoundMeshesOfAnySizeAndPlaceAreClean) {
  for (const double scale : {1e-7, 1e-3, 1.0, 1e4, 1e10}) {
    for (const Eigen::Vector3d& far : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1e6, -2e6, 3e6)}) {
      for (TriangleMesh mesh : {boxMesh({-1, -1, -1}, {1, 2, 3}), sphereMesh(1, 3), torusMesh(2, 0.5, 40, 20)}) {
        mesh = moved(std::move(mesh), far);
        const double volume = volumeOf(mesh);
        for (Eigen::Vector3d& p : mesh.positions) p *= scale;
        const MeshReport report = checkMesh(mesh);
        EXPECT_TRUE(report.clean()) << report.summary();
        EXPECT_EQ(report.summary(), "");
        EXPECT_EQ(report.components.size(), 1u);
        EXPECT_NEAR(report.volume / std::pow(scale, 3), volume, 1e-9 * volume + 1e-12 * volume * far.norm());
        EXPECT_EQ(report.components[0].volume, report.volume);
      }
    }
  }
}

TEST(MeshChecks, VolumeAndAreaOfABox) {
  const MeshReport report = checkMesh(moved(boxMesh({0, 0, 0}, {1, 2, 4}), {1e8, 1e8, 1e8}));
  EXPECT_DOUBLE_EQ(report.volume, 8);
  EXPECT_DOUBLE_EQ(report.area, 28);
  EXPECT_EQ(report.low, Eigen::Vector3d(1e8, 1e8, 1e8));
}

TEST(MeshChecks, AMissingTriangleIsAHoleOfThreeEdges) {
  TriangleMesh mesh = boxMesh({0, 0, 0}, {3, 3, 3});
  mesh.triangles.erase(mesh.triangles.begin() + 2);  // 4 5 7: of the face z = 3
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), Kinds{DefectKind::Border}) << report.summary();
  EXPECT_EQ(report.count(DefectKind::Border), 3u);
  ASSERT_EQ(report.holes.size(), 1u);
  EXPECT_EQ(report.holes[0].edges, 3u);
  EXPECT_DOUBLE_EQ(report.holes[0].length, 6 + 3 * std::sqrt(2.0));
  for (const Place& place : report.defects[0].first) EXPECT_DOUBLE_EQ(place.point.z(), 3);
  EXPECT_FALSE(report.not_checked.empty());
  EXPECT_FALSE(report.fixable());
}

TEST(MeshChecks, HolesAreListedLongestFirst) {
  TriangleMesh mesh = sphereMesh(10, 3);
  // The hole round the vertex at +z, then one triangle near -z.
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return t[0] == 4 || t[1] == 4 || t[2] == 4; });
  const auto last =
      std::find_if(mesh.triangles.begin(), mesh.triangles.end(), [](const Triangle& t) { return t[0] == 5 || t[1] == 5 || t[2] == 5; });
  mesh.triangles.erase(last);
  const MeshReport report = checkMesh(mesh);
  ASSERT_EQ(report.holes.size(), 2u);
  EXPECT_EQ(report.holes[0].edges, 4u);
  EXPECT_EQ(report.holes[1].edges, 3u);
  EXPECT_GT(report.holes[0].length, report.holes[1].length);
  EXPECT_EQ(report.count(DefectKind::Border), 7u);
}

TEST(MeshChecks, OneTurnedTriangleClashesWithItsThreeNeighbours) {
  TriangleMesh mesh = sphereMesh(1, 2);
  std::swap(mesh.triangles[7][0], mesh.triangles[7][1]);
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), Kinds{DefectKind::ClashingWinding}) << report.summary();
  EXPECT_EQ(report.count(DefectKind::ClashingWinding), 3u);
  for (const Place& place : report.defects[0].first)
    EXPECT_NE(std::find(place.triangles.begin(), place.triangles.end(), 7u), place.triangles.end());
}

TEST(MeshChecks, DuplicatesAndDegenerateTriangles) {
  TriangleMesh mesh = boxMesh({0, 0, 0}, {1, 1, 1});
  mesh.triangles.push_back({3, 0, 2});  // as triangle 0
  MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.count(DefectKind::DuplicateFace), 1u);
  EXPECT_EQ(report.defects[0].first[0].triangles, (std::vector<std::uint32_t>{12, 0}));
  EXPECT_EQ(report.count(DefectKind::NonManifoldEdge), 3u);

  mesh.triangles.back() = {3, 0, 3};
  report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), Kinds{DefectKind::DegenerateFace}) << report.summary();
  EXPECT_EQ(report.defects[0].first[0].triangles, std::vector<std::uint32_t>{12});

  mesh.positions.push_back({0.3, 0.3, 0.3});  // exactly on the diagonal of the box? rounded equally in each axis: yes
  mesh.triangles.back() = {0, 8, 7};
  EXPECT_EQ(checkMesh(mesh).count(DefectKind::DegenerateFace), 1u);
  mesh.positions[8].x() = std::nextafter(0.3, 1);
  EXPECT_EQ(checkMesh(mesh).count(DefectKind::DegenerateFace), 0u);
}

TEST(MeshChecks, AFinMakesANonManifoldEdge) {
  TriangleMesh mesh = boxMesh({0, 0, 0}, {1, 1, 1});
  mesh.positions.push_back({-1, -1, 0.5});
  mesh.triangles.push_back({0, 4, 8});  // on the edge of the vertices 0 and 4
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), (Kinds{DefectKind::NonManifoldEdge, DefectKind::Border})) << report.summary();
  EXPECT_EQ(report.count(DefectKind::NonManifoldEdge), 1u);
  EXPECT_EQ(report.defects[0].first[0].vertices, (std::vector<std::uint32_t>{0, 4}));
  EXPECT_EQ(report.defects[0].first[0].point, Eigen::Vector3d(0, 0, 0.5));
}

TEST(MeshChecks, TwoBodiesThatShareOneVertex) {
  TriangleMesh mesh = joined(boxMesh({0, 0, 0}, {1, 1, 1}), boxMesh({1, 1, 1}, {2, 2, 2}));
  for (Triangle& t : mesh.triangles)
    for (std::uint32_t& v : t) v = v == 8 ? 7 : v;
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), Kinds{DefectKind::NonManifoldVertex}) << report.summary();
  EXPECT_EQ(report.count(DefectKind::NonManifoldVertex), 1u);
  EXPECT_EQ(report.defects[0].first[0].vertices, std::vector<std::uint32_t>{7});
  EXPECT_EQ(report.defects[0].first[0].point, Eigen::Vector3d(1, 1, 1));
}

/// Concentric spheres; a minus sign means wound inward. The expected state of each, from the largest.
struct Nest {
  std::vector<int> windings;
  std::string fates;  // o: sound; i: inside out; c: cavity; b: buried. Upper case: its winding is also reversed
};

/// The spheres of `nest` with these radii, in this order or from the smallest.
TriangleMesh meshOf(const Nest& nest, const std::vector<double>& radii, bool is_reversed) {
  TriangleMesh mesh;
  for (std::size_t k = 0; k < radii.size(); ++k) {
    const std::size_t i = is_reversed ? radii.size() - 1 - k : k;
    const TriangleMesh sphere = sphereMesh(radii[i], 2);
    mesh = joined(std::move(mesh), nest.windings[i] > 0 ? sphere : flipped(sphere));
  }
  return mesh;
}

/// Where the winding number is above 0, summed over the shells from outside to inside.
double solidVolume(const Nest& nest, const std::vector<double>& radii) {
  double expected = 0;
  int winding = 0;
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const bool turned = nest.fates[i] >= 'A' && nest.fates[i] <= 'Z';
    winding += turned ? -nest.windings[i] : nest.windings[i];
    const double inner = i + 1 < radii.size() ? radii[i + 1] : 0;
    if (winding > 0) expected += volumeOf(sphereMesh(1, 2)) * (std::pow(radii[i], 3) - std::pow(inner, 3));
  }
  return expected;
}

TEST(MeshChecks, NestedSurfacesKeepWhatBoundsTheSolid) {
  const Nest nests[] = {
      {{1}, "o"},
      {{-1}, "O"},
      {{1, -1}, "oc"},
      {{1, 1}, "ob"},
      {{-1, 1}, "OC"},
      {{-1, -1}, "OB"},
      {{1, -1, 1}, "oco"},
      {{1, 1, -1}, "obb"},
      {{1, -1, -1}, "ocO"},
      {{-1, 1, -1}, "OCO"},
      {{1, -1, 1, -1}, "ococ"},
      {{1, 1, 1}, "obb"},
      {{1, 1, -1, -1}, "obbc"},
  };
  for (const Nest& nest : nests) {
    for (const bool is_reversed : {false, true}) {  // the order in the file must not matter
      std::vector<double> radii;
      for (std::size_t i = 0; i < nest.windings.size(); ++i) radii.push_back(static_cast<double>(10 - 2 * i));
      const TriangleMesh mesh = meshOf(nest, radii, is_reversed);
      const MeshReport report = checkMesh(mesh);
      ASSERT_EQ(report.components.size(), radii.size());
      std::string fates;
      for (std::size_t i = 0; i < radii.size(); ++i) {
        const Component& c = report.components[is_reversed ? radii.size() - 1 - i : i];
        const char fate = c.buried ? 'b' : c.cavity ? 'c' : 'o';
        fates += c.inside_out ? static_cast<char>(fate - 'a' + 'A') : fate;
      }
      EXPECT_EQ(fates, nest.fates);
      const bool is_turned = std::any_of(fates.begin(), fates.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
      EXPECT_EQ(report.clean(), !is_turned) << report.summary();
      EXPECT_TRUE(report.fixable());

      const TriangleMesh outward = orientOutward(mesh, report);
      const MeshReport second = checkMesh(outward);
      EXPECT_TRUE(second.clean()) << second.summary();
      EXPECT_EQ(second.buriedComponents(), report.buriedComponents());
      const TriangleMesh solid = withoutBuried(outward, second);
      const MeshReport third = checkMesh(solid);
      EXPECT_TRUE(third.clean());
      EXPECT_EQ(third.buriedComponents(), 0u);
      EXPECT_EQ(third.components.size(), radii.size() - report.buriedComponents());
      EXPECT_EQ(third.vertices, sphereMesh(1, 2).positions.size() * third.components.size());
      EXPECT_NEAR(third.volume, solidVolume(nest, radii), 4e-6) << nest.fates;
    }
  }
}

TEST(MeshChecks, SolidsSideBySideAreTurnedOneByOne) {
  const TriangleMesh mesh = joined(sphereMesh(1, 2), moved(flipped(sphereMesh(1, 2)), {5, 0, 0}));
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), Kinds{DefectKind::InsideOut});
  EXPECT_EQ(report.count(DefectKind::InsideOut), 1u);
  EXPECT_GT(report.defects[0].first[0].point.x(), 3);
  const TriangleMesh fixed = orientOutward(mesh, report);
  EXPECT_TRUE(checkMesh(fixed).clean());
  EXPECT_NEAR(volumeOf(fixed), 2 * volumeOf(sphereMesh(1, 2)), 1e-9);
}

TEST(MeshChecks, OverlappingSolidsCross) {
  const TriangleMesh mesh = joined(boxMesh({0, 0, 0}, {2, 2, 2}), boxMesh({1, 1, 1}, {3, 3, 3}));
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), Kinds{DefectKind::SelfIntersection}) << report.summary();
  EXPECT_EQ(report.buriedComponents(), 0u);
  EXPECT_TRUE(checkMesh(joined(boxMesh({0, 0, 0}, {2, 2, 2}), boxMesh({3, 0, 0}, {5, 2, 2}))).clean());
  EXPECT_TRUE(checkMesh(joined(boxMesh({0, 0, 0}, {2, 2, 2}), boxMesh({2, 0, 0}, {4, 2, 2}))).has(DefectKind::SelfIntersection));  // touch
}

TEST(MeshChecks, TheSearchForCrossingsStopsAtItsLimit) {
  TriangleMesh mesh;  // triangles standing around a common axis, slightly displaced: every pair crosses
  test::Random random(5);
  for (std::uint32_t t = 0; t < 600; ++t) {
    const double angle = t * 0.005, c = std::cos(angle), s = std::sin(angle);
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(9 * c, 9 * s, -5), Eigen::Vector3d(-9 * c, -9 * s, -5), Eigen::Vector3d(0, 0, 9)})
      mesh.positions.push_back(p + random.inCube(1e-3));
    mesh.triangles.push_back({3 * t, 3 * t + 1, 3 * t + 2});
  }
  const MeshReport report = checkMesh(mesh);
  EXPECT_EQ(report.count(DefectKind::SelfIntersection), kMaxCrossingPairs);
  EXPECT_NE(report.summary().find("more than 100000 pairs"), std::string::npos) << report.summary();
}

TEST(MeshChecks, NumbersThatNoBuilderCanUse) {
  EXPECT_EQ(kindsOf(checkMesh({})), Kinds{DefectKind::NoTriangles});
  TriangleMesh mesh = boxMesh({0, 0, 0}, {1, 1, 1});
  mesh.triangles[3][1] = 8;
  MeshReport report = checkMesh(mesh);
  EXPECT_EQ(kindsOf(report), Kinds{DefectKind::BadIndex});
  EXPECT_NE(report.summary().find("triangle 3, vertex 8"), std::string::npos) << report.summary();
  for (const double value : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    mesh = boxMesh({0, 0, 0}, {1, 1, 1});
    mesh.positions[0].y() = value;
    report = checkMesh(mesh);
    EXPECT_EQ(kindsOf(report), Kinds{DefectKind::NonFinite});
    EXPECT_EQ(report.count(DefectKind::NonFinite), 6u);  // triangles at vertex 0
    EXPECT_FALSE(report.not_checked.empty());
  }
  for (const double size : {1e-10, 1e13, 1e200, 1e308, 5e-324})
    EXPECT_EQ(kindsOf(checkMesh(boxMesh({-size, -size, -size}, {size, size, size}))), Kinds{DefectKind::Scale}) << size;
}

TEST(MeshChecks, AFlatSolidHasNoVolume) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {3, 3, 0}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  EXPECT_TRUE(checkMesh(mesh).has(DefectKind::NoVolume));
  mesh.positions[3].z() = 1e-3;  // thin, but a solid
  EXPECT_TRUE(checkMesh(mesh).clean()) << checkMesh(mesh).summary();
  // The same solid where double precision has lost its thickness.
  for (Eigen::Vector3d& p : mesh.positions) p.z() = p.z() * 1e-9 + 1e6;
  EXPECT_TRUE(checkMesh(mesh).has(DefectKind::NoVolume));
}

TEST(MeshChecks, TheOrderOfTrianglesChangesNoCount) {
  TriangleMesh mesh = joined(sphereMesh(3, 3), moved(torusMesh(2, 0.5, 30, 15), {1, 0, 0}));
  mesh.triangles.erase(mesh.triangles.begin() + 100);
  mesh.triangles.push_back(mesh.triangles[5]);
  std::swap(mesh.triangles[50][0], mesh.triangles[50][1]);
  const MeshReport expected = checkMesh(mesh);
  EXPECT_EQ(checkMesh(mesh).summary(), expected.summary());
  test::Random random(3);
  for (int round = 0; round < 5; ++round) {
    for (std::size_t i = mesh.triangles.size(); i > 1; --i) {
      std::swap(mesh.triangles[i - 1], mesh.triangles[random.below(i)]);
      std::rotate(mesh.triangles[i - 1].begin(), mesh.triangles[i - 1].begin() + 1, mesh.triangles[i - 1].end());
    }
    const MeshReport report = checkMesh(mesh);
    ASSERT_EQ(kindsOf(report), kindsOf(expected));
    for (const DefectKind kind : kindsOf(expected)) EXPECT_EQ(report.count(kind), expected.count(kind)) << name(kind);
  }
}

}  // namespace
}  // namespace spheretree::builder
