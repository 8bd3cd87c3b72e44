// SPDX-License-Identifier: GPL-3.0-or-later
#include "skin/surface_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "support/smooth_shapes.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

using test::kDegree;

std::size_t countOf(const SurfaceEdges& edges, EdgeKind kind) {
  return static_cast<std::size_t>(std::count(edges.kind.begin(), edges.kind.end(), kind));
}

std::size_t flatTriangleCount(const SurfaceEdges& edges) {
  return edges.flat_face.size() - static_cast<std::size_t>(std::count(edges.flat_face.begin(), edges.flat_face.end(), kNoIndex));
}

TEST(ClassifyEdges, OfABoxAreSharpAroundFlatFaces) {
  const SurfaceEdges edges = classifyEdges(test::quartered(test::boxMesh({0, 0, 0}, {1, 2, 3})), 50 * kDegree);
  EXPECT_EQ(edges.face_normal.size(), 6u);
  EXPECT_EQ(flatTriangleCount(edges), 48u);
  EXPECT_EQ(countOf(edges, EdgeKind::Sharp), 24u);
  EXPECT_EQ(countOf(edges, EdgeKind::Smooth), 0u);
}

TEST(ClassifyEdges, OfASphereAreAllSmooth) {
  const SurfaceEdges edges = classifyEdges(test::sphereMesh(3, 3), 50 * kDegree);
  EXPECT_EQ(countOf(edges, EdgeKind::Smooth), edges.kind.size());
  EXPECT_EQ(flatTriangleCount(edges), 0u);
}

TEST(ClassifyEdges, GoByTheCreaseAngle) {
  const TriangleMesh octahedron = test::sphereMesh(1, 0);  // its edges bend by 70.5 degrees
  EXPECT_EQ(countOf(classifyEdges(octahedron, 70 * kDegree), EdgeKind::Sharp), 12u);
  EXPECT_EQ(countOf(classifyEdges(octahedron, 71 * kDegree), EdgeKind::Sharp), 0u);
}

TEST(ClassifyEdges, OfACylinderKeepItsCapsFlatAndItsFacetsNot) {
  for (const double shift : {0.0, 1000.0}) {
    TriangleMesh mesh = test::cylinderMesh(3, 8, 32, 4);
    for (Vector3d& p : mesh.positions) p = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()) * p + shift * Vector3d::Ones();
    const SurfaceEdges edges = classifyEdges(mesh, 50 * kDegree);
    EXPECT_EQ(edges.face_normal.size(), 2u);
    EXPECT_EQ(flatTriangleCount(edges), 64u);
    EXPECT_EQ(countOf(edges, EdgeKind::Sharp), 64u);
  }
}

TEST(ClassifyEdges, KeepsFacesFlatThatRunIntoFillets) {
  const TriangleMesh mesh = test::filletedSlab(20, 10, 8, 2, 6);
  const SurfaceEdges edges = classifyEdges(mesh, 50 * kDegree);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vector3d n = edges.triangle_normal[t];
    const bool is_fillet = std::abs(n.y()) < 0.5 && n.z() > 1e-9 && n.z() < 1 - 1e-9;
    EXPECT_EQ(edges.flat_face[t] == kNoIndex, is_fillet) << "triangle " << t << ", normal " << n.transpose();
  }
}

TEST(ClassifyEdges, AtBordersAndWhereThreeTrianglesMeetAreSharp) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0.1}, {0.3, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  const auto middle = [](const SurfaceEdges& edges) { return edges.kind[edges.edge[0][0]]; };
  const SurfaceEdges pair = classifyEdges(mesh, 50 * kDegree);
  EXPECT_NE(middle(pair), EdgeKind::Sharp);
  EXPECT_EQ(countOf(pair, EdgeKind::Sharp), 4u);
  mesh.triangles[1] = {0, 1, 3};  // turned over
  EXPECT_EQ(middle(classifyEdges(mesh, 50 * kDegree)), EdgeKind::Sharp);
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  EXPECT_EQ(middle(classifyEdges(mesh, 50 * kDegree)), EdgeKind::Sharp);
}

TEST(ClassifyEdges, ANeedleMakesNoCrease) {
  // A vertex in the middle of a long edge, on one side of it only by a rounding error: the normal of the needle itself
  // is random.
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {1, -1, 0.01}, {1, 1, 0.02}, {1, 1e-9, 1e-9}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 4}, {0, 4, 3}, {4, 1, 3}};
  const SurfaceEdges edges = classifyEdges(mesh, 50 * kDegree);
  for (const std::uint32_t e : edges.edge[1]) EXPECT_NE(edges.kind[e], EdgeKind::Sharp);
}

TEST(ClassifyEdges, DoNotDependOnPoseAndScale) {
  const TriangleMesh mesh = test::filletedSlab(20, 10, 8, 2, 5);
  const SurfaceEdges edges = classifyEdges(mesh, 50 * kDegree);
  TriangleMesh moved = mesh;
  for (Vector3d& p : moved.positions) p = 0.01 * (Eigen::AngleAxisd(1.1, Vector3d(2, -1, 0.5).normalized()) * p) + Vector3d(3, 1, -2);
  const SurfaceEdges others = classifyEdges(moved, 50 * kDegree);
  EXPECT_EQ(edges.kind, others.kind);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) EXPECT_EQ(edges.flat_face[t] == kNoIndex, others.flat_face[t] == kNoIndex);
}

}  // namespace
}  // namespace spheretree::builder
