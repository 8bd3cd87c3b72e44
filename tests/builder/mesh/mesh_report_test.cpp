// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/builder/mesh_checks.h"

#include <gtest/gtest.h>

#include <set>

#include "spheretree/core/mesh_edit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;
using test::boxMesh;

TEST(MeshReport, TheSummaryNamesKindCountPlaceAndRemedy) {
  TriangleMesh mesh = boxMesh({0, 0, 0}, {3, 3, 3});
  mesh.triangles.erase(mesh.triangles.begin() + 2);
  const std::string text = checkMesh(mesh).summary();
  for (const char* words : {"border: 3 edges round 1 hole", "the longest 10.2426 mm", "at triangle", "Close the holes"})
    EXPECT_NE(text.find(words), std::string::npos) << text;
}

TEST(MeshReport, TheComponentsLeftOutTakeTheirPartsAlong) {
  TriangleMesh mesh = joined(test::sphereMesh(3, 1), test::sphereMesh(1, 1));
  mesh.part_names = {"outer", "inner"};
  mesh.part.assign(32, 0);
  mesh.part.resize(64, 1);
  const TriangleMesh solid = withoutBuried(mesh, checkMesh(mesh));
  EXPECT_EQ(solid.triangles.size(), 32u);
  EXPECT_EQ(solid.part, std::vector<std::uint32_t>(32, 0));
  EXPECT_EQ(solid.positions, test::sphereMesh(3, 1).positions);
  EXPECT_EQ(solid.part_names, mesh.part_names);
}

TEST(MeshReport, EveryKindHasANameAndARemedyOfItsOwn) {
  using enum DefectKind;
  std::set<std::string> names, texts;
  std::size_t kinds = 0;
  for (const DefectKind kind : {NoTriangles, BadIndex, NonFinite, Scale, DegenerateFace, DuplicateFace, NonManifoldEdge, NonManifoldVertex,
                                ClashingWinding, Border, NoVolume, InsideOut, SelfIntersection}) {
    MeshReport report;
    report.defects.push_back({kind, 2, true, {{{5, 6}, {7}, {1, 2, 3}}}});
    const std::string text = report.summary();
    EXPECT_TRUE(text.starts_with(std::string(name(kind)) + ": ")) << text;
    EXPECT_TRUE(text.ends_with("\n")) << text;
    if (kind != NoTriangles && kind != Scale) {
      EXPECT_NE(text.find("more than 2 "), std::string::npos) << text;
    }
    names.emplace(name(kind));
    texts.insert(text.substr(text.find(": ")));
    EXPECT_TRUE(report.has(kind));
    EXPECT_EQ(report.count(kind), 2u);
    EXPECT_EQ(report.fixable(), kind == InsideOut);
    ++kinds;
  }
  EXPECT_EQ(names.size(), kinds);
  EXPECT_EQ(texts.size(), kinds);
  EXPECT_TRUE(MeshReport{}.summary().empty());
}

TEST(MeshReport, OrientOutwardTurnsNothingElse) {
  const TriangleMesh right = joined(boxMesh({0, 0, 0}, {1, 1, 1}), boxMesh({3, 0, 0}, {4, 1, 1}));
  TriangleMesh mesh = right;
  for (std::size_t t = 12; t < 24; ++t) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  EXPECT_EQ(orientOutward(mesh, checkMesh(mesh)).triangles, right.triangles);
  EXPECT_EQ(orientOutward(right, checkMesh(right)).triangles, right.triangles);
}

}  // namespace
}  // namespace spheretree::builder
