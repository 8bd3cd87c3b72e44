// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/anchor_leaves.h"
#include "spheretree/core/rounding.h"

#include <Eigen/LU>
#include <Eigen/QR>

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

// Weights of corners 1 and 2 for a point of the triangle, by least squares, which also works for a triangle without
// area.
Eigen::Vector2d weightsOf(const Vector3d& p, const std::array<Vector3d, 3>& corner) {
  Eigen::Matrix<double, 3, 2> edges;
  edges << corner[1] - corner[0], corner[2] - corner[0];
  return edges.completeOrthogonalDecomposition().solve(p - corner[0]);
}

}  // namespace

std::vector<LeafAnchor> anchorLeaves(const TriangleMesh& mesh, const DistanceField& field, std::span<const TissueVertex> bound,
                                     const Tetrahedra& solid, std::span<const Sphere> leaves, const Vector3d& origin) {
  std::vector<LeafAnchor> anchors;
  for (const Sphere& leaf : leaves) {
    const Vector3d centre = centreOf(leaf) + origin;
    const NearestPoint nearest = field.nearest(centre);
    const Triangle& vertex = mesh.triangles[nearest.triangle];
    const Eigen::Vector2d weight =
        weightsOf(nearest.point, {mesh.positions[vertex[0]], mesh.positions[vertex[1]], mesh.positions[vertex[2]]});
    const std::uint32_t tetrahedron = bound[vertex[0]].tetrahedron;
    const auto& c = solid.corners[tetrahedron];
    Eigen::Matrix3d edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = solid.nodes[c[static_cast<std::size_t>(k) + 1]] - solid.nodes[c[0]];
    const Vector3d to = centre - nearest.point;
    const Vector3d direction = to.norm() > 0 ? Vector3d(edges.transpose() * to.normalized()) : Vector3d::Zero();
    anchors.push_back({vertex,
                       {roundToFloat(weight.x()), roundToFloat(weight.y())},
                       tetrahedron,
                       {roundToFloat(direction.x()), roundToFloat(direction.y()), roundToFloat(direction.z())},
                       roundToFloat(to.norm())});
  }
  return anchors;
}

}  // namespace spheretree::builder
