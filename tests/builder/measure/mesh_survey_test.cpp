// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/mesh_survey.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

MeshSurvey survey(const TriangleMesh& mesh) {
  Progress progress;
  return surveyMesh(mesh, checkMesh(mesh), progress);
}

/// A disc in the plane z = 0, round the z axis, cut out of a cone of which only the side is left.
TriangleMesh openCone(std::uint32_t sides, double radius) {
  TriangleMesh mesh;
  mesh.positions.emplace_back(0, 0, 7);
  for (std::uint32_t i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    mesh.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
    mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % sides});
  }
  return mesh;
}

TEST(MeshSurvey, ASoundMeshHasNothingToTell) {
  const TriangleMesh mesh = test::torusMesh(10, 3, 40, 20);
  EXPECT_EQ(summaryOf(survey(mesh), checkMesh(mesh)), "");
}

TEST(MeshSurvey, TheShapeOfABorder) {
  const MeshSurvey round = survey(openCone(100, 5));
  ASSERT_EQ(round.borders.size(), 1u);
  const BorderShape& circle = round.borders[0];
  EXPECT_TRUE(circle.is_loop);
  EXPECT_EQ(circle.edges, 100u);
  EXPECT_NEAR(circle.length, 100 * 10 * std::sin(std::numbers::pi / 100), 1e-9);
  EXPECT_NEAR(circle.roundness, 1, 1e-3);
  EXPECT_LT(circle.off_plane, 1e-12);
  EXPECT_LT(circle.centre.norm(), 1e-12);

  EXPECT_NEAR(survey(openCone(4, 5)).borders[0].roundness, std::numbers::pi / 4, 1e-12) << "a square";

  TriangleMesh bent = openCone(100, 5);
  for (std::size_t i = 1; i < bent.positions.size(); ++i) bent.positions[i].z() = i % 2 ? 0.25 : -0.25;
  EXPECT_NEAR(survey(bent).borders[0].off_plane, 0.25, 1e-9);

  TriangleMesh fan = test::boxMesh({0, 0, 0}, {1, 1, 1});  // two holes that meet in a vertex
  fan.triangles = {{0, 2, 3}, {0, 1, 5}};
  EXPECT_FALSE(survey(fan).borders[0].is_loop);
}

TEST(MeshSurvey, CracksAndTJunctions) {
  TriangleMesh box = test::boxMesh({0, 0, 0}, {10, 10, 10});
  // One triangle is separated by a tiny distance.
  TriangleMesh cracked = box;
  for (std::uint32_t& v : cracked.triangles[0]) {
    cracked.positions.push_back(cracked.positions[v] + Vector3d(0, 0, 5e-4));
    v = static_cast<std::uint32_t>(cracked.positions.size() - 1);
  }
  const MeshSurvey crack = survey(cracked);
  EXPECT_EQ(crack.cracks.size(), 6u) << "three corners, seen from both sides";
  EXPECT_TRUE(crack.t_junctions.empty());
  for (const Seam& s : crack.cracks) EXPECT_NEAR(s.gap, 5e-4, 1e-12);

  for (std::uint32_t v : {8u, 9u, 10u}) cracked.positions[v].z() += 0.1;
  EXPECT_TRUE(survey(cracked).cracks.empty()) << "that is a hole";

  // A side is split on one triangle only.
  TriangleMesh split = box;
  split.positions.emplace_back(5, 5, 0);  // the middle of the diagonal of triangles 0 and 1
  const Triangle whole = split.triangles[0];
  std::size_t k = 0;
  const auto onDiagonal = [&](std::uint32_t v) { return v == 0 || v == 3; };
  while (!(onDiagonal(whole[k]) && onDiagonal(whole[(k + 1) % 3]))) ++k;
  split.triangles[0] = {whole[k], 8, whole[(k + 2) % 3]};
  split.triangles.push_back({8, whole[(k + 1) % 3], whole[(k + 2) % 3]});
  const MeshSurvey junction = survey(split);
  ASSERT_EQ(junction.t_junctions.size(), 1u);
  EXPECT_EQ(junction.t_junctions[0].vertex, 8u);
  EXPECT_EQ(junction.t_junctions[0].other, 1u);
  EXPECT_TRUE(junction.cracks.empty());
}

TEST(MeshSurvey, TheSmallerGroupIsReversed) {
  TriangleMesh mesh = test::sphereMesh(5, 3);
  for (const std::uint32_t t : {3u, 77u, 400u}) std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  EXPECT_EQ(survey(mesh).turned, (std::vector<std::uint32_t>{3, 77, 400}));
  for (Triangle& t : mesh.triangles) std::swap(t[0], t[1]);
  EXPECT_EQ(survey(mesh).turned, (std::vector<std::uint32_t>{3, 77, 400}));
}

TEST(MeshSurvey, AMoebiusStripHasOneSide) {
  TriangleMesh strip;
  constexpr std::uint32_t kSteps = 24;
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const double u = 2 * std::numbers::pi * i / kSteps;
    for (const double side : {-1.0, 1.0}) {
      const double r = 10 + side * std::cos(u / 2);
      strip.positions.emplace_back(r * std::cos(u), r * std::sin(u), side * std::sin(u / 2));
    }
  }
  for (std::uint32_t i = 0; i < kSteps; ++i) {
    const std::uint32_t a = 2 * i, b = 2 * i + 1, c = i + 1 < kSteps ? a + 2 : 1, d = i + 1 < kSteps ? a + 3 : 0;
    strip.triangles.push_back({a, c, b});
    strip.triangles.push_back({b, c, d});
  }
  const MeshSurvey found = survey(strip);
  EXPECT_EQ(found.one_sided, std::vector<std::uint32_t>{0});
  EXPECT_TRUE(found.turned.empty());
}

TEST(MeshSurvey, TinyPartsAndUnlikelyUnits) {
  const TriangleMesh big = test::boxMesh({0, 0, 0}, {20, 20, 20}), crumb = test::boxMesh({30, 0, 0}, {30.1, 0.1, 0.1});
  EXPECT_EQ(survey(test::joined(big, crumb)).tiny, std::vector<std::uint32_t>{1});
  EXPECT_TRUE(survey(test::joined(big, test::boxMesh({30, 0, 0}, {31, 1, 1}))).tiny.empty());

  EXPECT_EQ(survey(big).unit_hint, "");
  EXPECT_NE(survey(test::boxMesh({0, 0, 0}, {0.02, 0.01, 0.01})).unit_hint.find("--unit m makes it 24.5 mm"), std::string::npos);
  EXPECT_NE(survey(test::boxMesh({0, 0, 0}, {1, 0.5, 0.3})).unit_hint.find("--unit m makes it 1.16e+03 mm"), std::string::npos)
      << "a link of a robot, in metres";
  EXPECT_NE(survey(test::boxMesh({0, 0, 0}, {20000, 1e4, 1e4})).unit_hint.find("very large"), std::string::npos);
}

TEST(MeshSurvey, EveryUnitThatFitsIsProposed) {
  EXPECT_EQ(unitHint(16000, 1000),
            "the diagonal is 1.6e+04 mm, very large: --unit mm makes it 16 mm, --unit cm makes it 160 mm, --unit in makes it 406 mm.")
      << "a glTF in mm";
  EXPECT_EQ(unitHint(16, 1), "");
}

TEST(MeshSurvey, ThicknessAndLeavesOfKnownSolids) {
  const MeshSurvey ball = survey(test::sphereMesh(5, 4));
  ASSERT_TRUE(ball.has_inside);
  EXPECT_LE(ball.thickness.median, 10 + 1e-9);
  EXPECT_GE(ball.thickness.median, 9) << "flat facets: a ball that touches one beside its middle is a little smaller";
  const MeshSurvey slab = survey(test::boxMesh({0, 0, 0}, {40, 40, 1}));
  EXPECT_NEAR(slab.thickness.median, 1, 0.01);
  // A slab of thickness 2r and area A: 2 n pi h (2r + h) = 1.2092 A (docs/measures.md).
  const LeafEstimate& e = slab.leaf_estimates[1];
  EXPECT_NEAR(static_cast<double>(e.leaves), 1.2092 * (2 * 1600 + 160) / (2 * std::numbers::pi * e.overhang * (1 + e.overhang)),
              0.15 * static_cast<double>(e.leaves));
  EXPECT_TRUE(std::is_sorted(slab.leaf_estimates.begin(), slab.leaf_estimates.end(),
                             [](const LeafEstimate& a, const LeafEstimate& b) { return a.leaves < b.leaves; }));
  EXPECT_FALSE(survey(openCone(10, 3)).has_inside);
}

TEST(MeshSurvey, BadNumbersAndCancelling) {
  TriangleMesh broken = test::boxMesh({0, 0, 0}, {1, 1, 1});
  broken.triangles[0][1] = 99;
  EXPECT_TRUE(survey(broken).borders.empty());
  EXPECT_FALSE(survey({}).has_inside);
  Progress progress;
  progress.cancel();
  const TriangleMesh mesh = test::sphereMesh(1, 2);
  EXPECT_THROW(surveyMesh(mesh, checkMesh(mesh), progress), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
