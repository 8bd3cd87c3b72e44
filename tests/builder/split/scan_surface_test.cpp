// SPDX-License-Identifier: GPL-3.0-or-later
#include "split/scan_surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "support/random.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// Each directed edge once, and the triangles at each vertex in one fan.
bool isManifold(const TriangleMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> face;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k)
      if (!face.emplace(std::pair{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}, t).second) return false;
  std::map<std::uint32_t, std::vector<std::uint32_t>> at;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t]) at[v].push_back(t);
  for (const auto& [v, triangles] : at) {
    std::set<std::uint32_t> fan{triangles[0]};
    for (bool more = true; more;) {
      more = false;
      for (const std::uint32_t t : std::set<std::uint32_t>(fan))
        for (const std::uint32_t w : mesh.triangles[t])
          for (const auto& edge : {std::pair{v, w}, std::pair{w, v}})
            if (const auto found = face.find(edge); found != face.end()) more = fan.insert(found->second).second || more;
    }
    if (fan.size() != triangles.size()) return false;
  }
  return true;
}

TEST(EdgeFaces, FindsTheTriangleOfEachDirectedEdge) {
  TriangleMesh mesh = test::sphereMesh(3, 2);
  mesh.triangles.resize(mesh.triangles.size() / 2);  // with a border
  const EdgeFaces faces(mesh);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> wanted;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) wanted[{mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3]}] = t;
  for (std::uint32_t a = 0; a < mesh.positions.size(); ++a)
    for (std::uint32_t b = 0; b < mesh.positions.size(); ++b) {
      const auto found = wanted.find({a, b});
      ASSERT_EQ(faces.face(a, b), found == wanted.end() ? kNone : found->second);
    }
}

TEST(TrianglesNear, EachRingTouchesTheOneBefore) {
  const TriangleMesh mesh = test::sphereMesh(3, 3);
  const std::vector<std::uint32_t> one{5};
  std::set<std::uint32_t> corners{5};
  for (int rings = 1; rings <= 4; ++rings) {
    std::vector<std::uint32_t> wanted;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      if (std::any_of(mesh.triangles[t].begin(), mesh.triangles[t].end(), [&](std::uint32_t v) { return corners.count(v) > 0; }))
        wanted.push_back(t);
    EXPECT_EQ(trianglesNear(mesh, one, rings), wanted) << rings;
    for (const std::uint32_t t : wanted) corners.insert(mesh.triangles[t].begin(), mesh.triangles[t].end());
  }
  EXPECT_TRUE(trianglesNear(mesh, {}, 3).empty());
}

TEST(MakeManifold, LeavesASoundSurfaceAlone) {
  TriangleMesh mesh = test::sphereMesh(3, 2);
  const auto before = mesh.triangles;
  EXPECT_EQ(makeManifold(mesh), 0);
  EXPECT_EQ(mesh.triangles, before);
}

TEST(MakeManifold, TheSmallestOfThreeTrianglesAtAnEdgeGoes) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 3, 0}, {0, -2, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};  // areas 1.5, 1, 0.5; the first and the last run the same way
  EXPECT_DOUBLE_EQ(makeManifold(mesh), 0.5);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {1, 0, 3}}));
}

TEST(MakeManifold, OfFansThatMeetInAPointTheLargestStays) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {-1, 0, 0}, {0, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  EXPECT_DOUBLE_EQ(makeManifold(mesh), 0.5);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}}));
}

TEST(MakeManifold, AnySoupEndsAsOne) {
  test::Random random(3);
  for (int n = 0; n < 40; ++n) {
    TriangleMesh mesh;
    for (int v = 0; v < 12; ++v) mesh.positions.push_back(random.inCube(5));
    for (int t = 0; t < 40; ++t) {
      const auto any = [&] { return static_cast<std::uint32_t>(random.below(12)); };
      const Triangle triangle{any(), any(), any()};
      if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0]) mesh.triangles.push_back(triangle);
    }
    const double before = surfaceArea(mesh), lost = makeManifold(mesh);
    EXPECT_TRUE(isManifold(mesh));
    EXPECT_FALSE(mesh.triangles.empty());
    EXPECT_NEAR(surfaceArea(mesh), before - lost, 1e-9 * before);
  }
}

}  // namespace
}  // namespace spheretree::builder
