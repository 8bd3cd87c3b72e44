// SPDX-License-Identifier: GPL-3.0-or-later
#include "repair/arrange_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "mesh/crossing_triangles.h"
#include "spheretree/core/mesh_edit.h"
#include "support/mesh_measures.h"
#include "support/shapes.h"
#include "support/soup.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

std::optional<Arrangement> arranged(const TriangleMesh& mesh, std::size_t max_pieces = 1'000'000) {
  Progress progress;
  RepairWork work(progress);
  return arrangeTriangles(mesh, findCrossingTriangles(mesh, 1'000'000).pairs, max_pieces, progress, work);
}

// The pieces of each triangle have its area and lie on it.
TEST(ArrangeTriangles, PiecesFillTheirTriangles) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const TriangleMesh mesh = test::randomTriangles(60, 0.7, seed);
    const auto result = arranged(mesh);
    ASSERT_TRUE(result);
    std::vector<double> area(mesh.triangles.size(), 0);
    for (std::size_t f = 0; f < result->facets.size(); ++f)
      for (const Arrangement::Member& m : result->membersOf(f)) {
        area[m.triangle] += result->area(f);
        const Vector3d a = mesh.corner(m.triangle, 0);
        const Vector3d normal = (mesh.corner(m.triangle, 1) - a).cross(mesh.corner(m.triangle, 2) - a).normalized();
        for (const std::uint32_t v : result->facets[f]) EXPECT_NEAR((result->positions[v] - a).dot(normal), 0, 1e-14);
      }
    EXPECT_GT(result->facets.size(), 3 * mesh.triangles.size());
    for (std::size_t t = 0; t < area.size(); ++t) {
      const Vector3d a = mesh.corner(t, 0);
      EXPECT_NEAR(area[t], 0.5 * (mesh.corner(t, 1) - a).cross(mesh.corner(t, 2) - a).norm(), 1e-12);
    }
  }
}

// Three planes across each axis: three of them meet in points that each must number alike.
TEST(ArrangeTriangles, PiecesMeetOnlyInCornersAndEdges) {
  TriangleMesh mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double at : {-1.0, 0.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (const auto& [u, v] : {std::pair{-2, -2}, {2, -2}, {2, 2}, {-2, 2}}) {
        Vector3d p;
        p[axis] = at, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
        mesh.positions.push_back(p);
      }
      mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
    }
  const auto result = arranged(mesh);
  ASSERT_TRUE(result);
  const TriangleMesh pieces{result->positions, result->facets, {}, {}};
  EXPECT_TRUE(findCrossingTriangles(pieces, 1).pairs.empty());
  EXPECT_NEAR(test::areaOf(pieces), 9 * 16, 1e-12);
}

TEST(ArrangeTriangles, TrianglesWithTheSameCornersAreOneFacet) {
  TriangleMesh mesh = test::boxMesh({0, 0, 0}, {1, 1, 1});
  const auto [a, b, c] = mesh.triangles[0];
  mesh.triangles.insert(mesh.triangles.end(), {{b, c, a}, {a, c, b}});
  const auto result = arranged(mesh);
  ASSERT_TRUE(result);
  ASSERT_EQ(result->facets.size(), 12u);
  ASSERT_EQ(result->membersOf(0).size(), 3u);
  EXPECT_EQ(result->net(0), 1);
}

// A star of thin bars through one middle: every bar cuts every other one.
TEST(ArrangeTriangles, KnowsWhenThereWouldBeTooManyPieces) {
  TriangleMesh star;
  for (int i = 0; i < 24; ++i) {
    TriangleMesh bar = test::boxMesh({-1, -0.01, -0.01}, {1, 0.01, 0.01});
    const double turn = std::numbers::pi * i / 24, lift = 1e-7 * std::sin(7.0 * i);
    for (Vector3d& p : bar.positions)
      p = Vector3d(std::cos(turn) * p.x() - std::sin(turn) * p.y(), std::sin(turn) * p.x() + std::cos(turn) * p.y(), p.z() + lift);
    star = joined(star, bar);
  }
  const auto whole = arranged(star);
  ASSERT_TRUE(whole);
  EXPECT_GT(whole->facets.size(), 4 * star.triangles.size());
  EXPECT_FALSE(arranged(star, 4 * star.triangles.size()));
  Progress progress;
  RepairWork little(progress, 10'000);
  const auto pairs = findCrossingTriangles(star, 1'000'000).pairs;
  EXPECT_THROW(arrangeTriangles(star, pairs, 1'000'000, progress, little), TooMuchWork);
  progress.cancel();
  RepairWork work(progress);
  EXPECT_THROW(arrangeTriangles(star, pairs, 1'000'000, progress, work), Cancelled);
}

}  // namespace
}  // namespace spheretree::builder
