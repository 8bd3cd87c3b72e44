// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/smooth_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/smooth_shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

using test::kDegree;

SmoothSurface smoothOf(const TriangleMesh& mesh, SurfaceEdges& edges) {
  edges = classifyEdges(mesh, 50 * kDegree);
  return smoothSurface(mesh, edges);
}

double angleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

struct Worst {
  double corner = 0, side = 0;  // of normals [rad]
  double middle = 0;            // of the middles of sides from the surface [mm]
};

/// `surface` gives the point nearest to p, and the normal there.
template <class Surface>
Worst worstOf(const TriangleMesh& mesh, Surface surface) {
  SurfaceEdges edges;
  const SmoothSurface smooth = smoothOf(mesh, edges);
  Worst worst;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d a = mesh.corner(t, static_cast<int>(k)), b = mesh.corner(t, static_cast<int>((k + 1) % 3));
      const Vector3d middle = 0.5 * (a + b) + smooth.offset[edges.edge[t][k]];
      worst.corner = std::max(worst.corner, angleBetween(smooth.corner_normal[t][k], surface(a)[1]));
      worst.side = std::max(worst.side, angleBetween(smooth.side_normal[t][k], surface(middle)[1]));
      worst.middle = std::max(worst.middle, (middle - surface(middle)[0]).norm());
    }
  return worst;
}

TEST(SmoothSurfaceOfMesh, FollowsASphere) {
  const auto surface = [](const Vector3d& p) { return std::array<Vector3d, 2>{5 * p.normalized(), p.normalized()}; };
  const Worst coarse = worstOf(test::sphereMesh(5, 3), surface), fine = worstOf(test::sphereMesh(5, 4), surface);
  EXPECT_LT(fine.corner, 0.003);
  EXPECT_LT(fine.middle, 5e-4);  // the middle of an edge of the mesh is up to 0.05 inside
  EXPECT_LT(fine.middle, 0.3 * coarse.middle);
}

TEST(SmoothSurfaceOfMesh, FollowsATorusToTheFourthOrder) {
  const auto surface = [](const Vector3d& p) {
    const Vector3d c = 6 * Vector3d(p.x(), p.y(), 0).normalized(), n = (p - c).normalized();
    return std::array<Vector3d, 2>{c + 2 * n, n};
  };
  const Worst coarse = worstOf(test::torusMesh(6, 2, 32, 16), surface), fine = worstOf(test::torusMesh(6, 2, 64, 32), surface);
  EXPECT_LT(fine.corner, 1e-4);
  EXPECT_LT(fine.side, 1e-4);
  EXPECT_LT(fine.middle, 1e-4);  // the middle of an edge of the mesh is up to 0.01 inside
  EXPECT_LT(fine.middle, 0.1 * coarse.middle);
  EXPECT_LT(fine.side, 0.15 * coarse.side);
}

// Masks of a subdivision surface alone turn corners by 6 and sides by 10 degrees on the fine ones of these.
TEST(SmoothSurfaceOfMesh, FollowsATorusOfIrregularTriangles) {
  const auto surface = [](const Vector3d& p) {
    const Vector3d c = 6 * Vector3d(p.x(), p.y(), 0).normalized(), n = (p - c).normalized();
    return std::array<Vector3d, 2>{c + 2 * n, n};
  };
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Worst coarse = worstOf(test::irregularTorus(6, 2, 48, 24, seed), surface);
    const Worst fine = worstOf(test::irregularTorus(6, 2, 96, 48, seed), surface);
    EXPECT_LT(coarse.corner, 5 * kDegree);
    EXPECT_LT(fine.corner, 0.25 * kDegree);
    EXPECT_LT(fine.side, 0.15 * kDegree);
    EXPECT_LT(fine.middle, 0.01);
  }
}

// Two fans of 20,000 triangles: fits over all neighbours of a hub would take hours.
TEST(SmoothSurfaceOfMesh, AFanCostsNoMoreThanItsTriangles) {
  const std::uint32_t around = 20000;
  TriangleMesh lens;
  for (std::uint32_t i = 0; i < around; ++i) {
    const double angle = 2 * std::numbers::pi * i / around;
    lens.positions.emplace_back(10 * std::cos(angle), 10 * std::sin(angle), 0);
  }
  lens.positions.emplace_back(0, 0, 2);
  lens.positions.emplace_back(0, 0, -2);
  for (std::uint32_t i = 0; i < around; ++i) {
    lens.triangles.push_back({i, (i + 1) % around, around});
    lens.triangles.push_back({(i + 1) % around, i, around + 1});
  }
  SurfaceEdges edges;
  const SmoothSurface smooth = smoothOf(lens, edges);
  for (std::uint32_t t = 0; t < lens.triangles.size(); ++t)
    for (const Vector3d& n : smooth.corner_normal[t]) EXPECT_GT(n.dot(edges.triangle_normal[t]), 0.5);
}

TEST(SmoothSurfaceOfMesh, FollowsACylinderUpToItsCreases) {
  const TriangleMesh mesh = test::cylinderMesh(3, 8, 32, 6);
  SurfaceEdges edges;
  const SmoothSurface smooth = smoothOf(mesh, edges);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const bool is_cap = std::abs(edges.triangle_normal[t].z()) > 0.5;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3d a = mesh.corner(t, static_cast<int>(k)), middle = 0.5 * (a + mesh.corner(t, static_cast<int>((k + 1) % 3)));
      const auto radial = [](const Vector3d& p) { return Vector3d(p.x(), p.y(), 0).normalized(); };
      EXPECT_LT(angleBetween(smooth.corner_normal[t][k], is_cap ? edges.triangle_normal[t] : radial(a)), 1e-3);
      EXPECT_LT(angleBetween(smooth.side_normal[t][k], is_cap ? edges.triangle_normal[t] : radial(middle)), 2e-3);
      const Vector3d offset = smooth.offset[edges.edge[t][k]];
      if (is_cap || edges.isSharp(edges.edge[t][k]))
        EXPECT_EQ(offset, Vector3d::Zero());
      else
        EXPECT_NEAR(Vector3d(middle.x() + offset.x(), middle.y() + offset.y(), 0).norm(), 3, 2e-4);  // 0.014 without the offset
    }
  }
}

TEST(SmoothSurfaceOfMesh, OfFlatFacesHasTheirNormals) {
  const TriangleMesh mesh = test::filletedSlab(20, 10, 8, 2, 6);
  SurfaceEdges edges;
  const SmoothSurface smooth = smoothOf(mesh, edges);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) {
      if (edges.flat_face[t] == kNoIndex) {
        // A quarter of a cylinder: the normal is that of the circle wherever the fillet is not cut off by a sharp edge.
        const Vector3d p = mesh.corner(t, static_cast<int>(k));
        const Vector3d n = Vector3d(p.x() < 10 ? p.x() : p.x() - 20, 0, p.z() - 6).normalized();
        EXPECT_LT(angleBetween(smooth.corner_normal[t][k], n), 1e-3);
        continue;
      }
      EXPECT_EQ(smooth.corner_normal[t][k], edges.face_normal[edges.flat_face[t]]);
      EXPECT_EQ(smooth.side_normal[t][k], edges.face_normal[edges.flat_face[t]]);
      EXPECT_EQ(smooth.offset[edges.edge[t][k]], Vector3d::Zero());
    }
}

TEST(SmoothSurfaceOfMesh, FollowsAMotionOfTheMesh) {
  const TriangleMesh mesh = test::torusMesh(6, 2, 24, 12);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.9, Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  TriangleMesh moved = mesh;
  for (Vector3d& p : moved.positions) p = 0.1 * (turn * p) + Vector3d(5, 6, 7);
  SurfaceEdges edges;
  const SmoothSurface one = smoothOf(mesh, edges), other = smoothOf(moved, edges);
  for (std::size_t e = 0; e < one.offset.size(); ++e) EXPECT_LT((0.1 * (turn * one.offset[e]) - other.offset[e]).norm(), 1e-12);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) EXPECT_LT((turn * one.corner_normal[t][k] - other.corner_normal[t][k]).norm(), 1e-12);
}

TEST(SmoothSurfaceOfMesh, IsTheSameFromBothTrianglesOfASmoothEdge) {
  TriangleMesh mesh = test::sphereMesh(5, 3);
  test::Random random(4);
  for (Vector3d& p : mesh.positions) p += random.inCube(0.05);
  SurfaceEdges edges;
  const SmoothSurface smooth = smoothOf(mesh, edges);
  for (std::uint32_t e = 0; e < edges.kind.size(); ++e) {
    const auto [s, t] = edges.triangle[e];
    const auto sideOf = [&](std::uint32_t triangle) {
      return static_cast<std::size_t>(std::find(edges.edge[triangle].begin(), edges.edge[triangle].end(), e) -
                                      edges.edge[triangle].begin());
    };
    EXPECT_EQ(smooth.side_normal[s][sideOf(s)], smooth.side_normal[t][sideOf(t)]);
    EXPECT_NEAR(smooth.side_normal[s][sideOf(s)].norm(), 1, 1e-12);
  }
}

}  // namespace
}  // namespace spheretree::builder
