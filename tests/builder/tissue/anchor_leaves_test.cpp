// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/anchor_leaves.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "support/random.h"
#include "support/shapes.h"
#include "support/tetrahedra.h"
#include "tissue/bind_surface.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

/// A box far from the origin of its frame, filled with tetrahedra.
struct AnchorBox {
  Vector3d low{300, -200, 50}, size{8, 6, 5}, origin{303, -198, 52};
  TriangleMesh mesh = test::quartered(test::quartered(test::boxMesh(low, low + size)));
  Tetrahedra solid = test::boxTetrahedra(size, {3, 2, 2});
  std::vector<TissueVertex> bound;

  AnchorBox() {
    for (Vector3d& p : solid.nodes) p += low;
    Progress progress;
    bound = bindSurface(mesh, solid, origin, progress);
  }
  std::vector<LeafAnchor> anchors(std::span<const Sphere> leaves) const {
    return anchorLeaves(mesh, DistanceField(mesh), bound, solid, leaves, origin);
  }
  /// The point of the surface that an anchor names.
  Vector3d pointOf(const LeafAnchor& a) const {
    const auto corner = [&](std::size_t k) { return mesh.positions[a.vertex[k]]; };
    const double u = a.weight[0], v = a.weight[1];
    return (1 - u - v) * corner(0) + u * corner(1) + v * corner(2);
  }
  /// The direction that has the given dot products with the edges of its tetrahedron.
  Vector3d directionOf(const LeafAnchor& a) const {
    Eigen::Matrix3d edges;
    const auto& c = solid.corners[a.tetrahedron];
    for (int k = 0; k < 3; ++k) edges.row(k) = (solid.nodes[c[static_cast<std::size_t>(k) + 1]] - solid.nodes[c[0]]).transpose();
    return edges.inverse() * Vector3d(a.direction[0], a.direction[1], a.direction[2]);
  }
};

std::vector<Sphere> randomLeaves(const AnchorBox& box, std::size_t count) {
  test::Random random(3);
  std::vector<Sphere> leaves;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d p = random.inBox(box.low - Vector3d::Ones(), box.low + box.size + Vector3d::Ones()) - box.origin;
    leaves.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()), 1});
  }
  return leaves;
}

TEST(AnchorLeaves, AtRestAnAnchorGivesTheCentreOfItsLeaf) {
  const AnchorBox box;
  const std::vector<Sphere> leaves = randomLeaves(box, 300);
  const std::vector<LeafAnchor> anchors = box.anchors(leaves);
  ASSERT_EQ(anchors.size(), leaves.size());
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const LeafAnchor& a = anchors[i];
    const Vector3d centre = centreOf(leaves[i]) + box.origin;
    EXPECT_NEAR(a.depth, std::abs(test::boxDistance(box.low, box.low + box.size, centre)), 1e-6) << "the nearest point of the surface";
    EXPECT_NEAR(box.directionOf(a).norm(), 1, 1e-6);
    EXPECT_LT((box.pointOf(a) + a.depth * box.directionOf(a) - centre).norm(), 1e-5) << "float: 4 mm in units of 5e-7";
    EXPECT_EQ(a.tetrahedron, box.bound[a.vertex[0]].tetrahedron);
    EXPECT_TRUE(std::find(box.mesh.triangles.begin(), box.mesh.triangles.end(), a.vertex) != box.mesh.triangles.end());
    EXPECT_GE(std::min({a.weight[0], a.weight[1], 1 - a.weight[0] - a.weight[1]}), -1e-6f);
  }
}

TEST(AnchorLeaves, ALeafOnTheSurfaceHasNoDirection) {
  const AnchorBox box;
  const std::vector<Sphere> on_face{{1, 0.5f, -2, 1}, {-3, -2, -2, 1}};  // on the bottom; a corner
  for (const LeafAnchor& a : box.anchors(on_face)) {
    EXPECT_EQ(a.depth, 0);
    EXPECT_EQ(a.direction, (std::array<float, 3>{0, 0, 0}));
  }
}

// Its corners are in line: the weights are not unique, but name the point.
TEST(AnchorLeaves, ATriangleWithoutAreaCanHoldALeaf) {
  AnchorBox box;
  box.mesh = TriangleMesh{{box.low, box.low + Vector3d(4, 0, 0), box.low + Vector3d(1, 0, 0)}, {{0, 1, 2}}, {}, {}};
  Progress progress;
  box.bound = bindSurface(box.mesh, box.solid, box.origin, progress);
  const std::vector<Sphere> above{{-1, -2, 1, 1}};
  const LeafAnchor a = box.anchors(above)[0];
  EXPECT_LT((box.pointOf(a) - (box.low + Vector3d(2, 0, 0))).norm(), 1e-5);
  EXPECT_NEAR(a.depth, 3, 1e-6);
  EXPECT_LT((box.directionOf(a) - Vector3d::UnitZ()).norm(), 1e-6);
}

}  // namespace
}  // namespace spheretree::builder
