// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/surface_response.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "support/tetrahedra.h"
#include "tissue/tetrahedra.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

struct Block {
  Tetrahedra solid;
  TissueResponse response;

  /// Fixed below z = 0.
  Block(const Vector3d& size, const std::array<std::uint32_t, 3>& cells, const TissueMaterial& material)
      : solid(test::boxTetrahedra(size, cells)) {
    std::vector<char> fixed;
    for (const Vector3d& p : solid.nodes) fixed.push_back(p.z() < 1e-9);
    Progress progress;
    response = surfaceResponse(Elasticity(solid, material, fixed, progress), boundaryOf(solid), progress);
  }

  std::size_t pressedAt(const Vector3d& place) const {
    for (std::size_t i = 0; i < response.pressed.size(); ++i)
      if ((solid.nodes[response.pressed[i]] - place).norm() < 1e-6) return i;
    ADD_FAILURE() << "no node there";
    return 0;
  }
  double alongZ(const Vector3d& place) const {
    const std::size_t i = pressedAt(place);
    return static_cast<double>(response.column(i, 2)[3 * i + 2]);
  }
};

TEST(SurfaceResponse, IsTheInverseOfYoungsModulusAndOfTheSize) {  // displacement over force: 1 / (E length)
  const Vector3d size(8, 6, 4), top(4, 3, 4);
  const double soft = Block(size, {2, 2, 2}, {10, 0.4, 1040}).alongZ(top), stiff = Block(size, {2, 2, 2}, {40, 0.4, 1040}).alongZ(top),
               large = Block(10 * size, {2, 2, 2}, {10, 0.4, 1040}).alongZ(10 * top);
  EXPECT_GT(stiff, 0);
  EXPECT_NEAR(soft, 4 * stiff, 1e-6 * soft);
  EXPECT_NEAR(soft, 10 * large, 1e-6 * soft);
}

TEST(SurfaceResponse, IsSymmetricAndPositive) {
  const Block block({8, 6, 4}, {3, 2, 2}, {15, 0.45, 1040});
  const TissueResponse& r = block.response;
  const auto n = static_cast<Eigen::Index>(3 * r.pressed.size());
  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i)
      matrix(i, j) =
          static_cast<double>(r.column(static_cast<std::size_t>(j / 3), static_cast<std::size_t>(j % 3))[static_cast<std::size_t>(i)]);
  EXPECT_LT((matrix - matrix.transpose()).cwiseAbs().maxCoeff(), 1e-6 * matrix.maxCoeff());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(matrix).eigenvalues().minCoeff(), 0);
  for (const std::uint32_t node : r.pressed) EXPECT_GT(block.solid.nodes[node].z(), 0) << "a fixed node";
}

// Integral over a triangle of its linear hats times the shape functions of quadratic elements, by six points, exact to
// degree 4 (G. Strang, G. Fix, An Analysis of the Finite Element Method, 1973).
template <class Visit>
void integrate(const Visit& visit) {
  const double a = 0.445948490915965, b = 0.091576213509771, wa = 0.223381589678011, wb = 0.109951743655322;
  for (std::size_t k = 0; k < 3; ++k)
    for (const auto& [inner, weight] : {std::pair(a, wa), std::pair(b, wb)}) {
      std::array<double, 3> hat{inner, inner, inner};
      hat[k] = 1 - 2 * inner;
      visit(hat, weight);
    }
}

// Against elasticity itself, with traction and mean displacement by another rule of integration.
TEST(SurfaceResponse, IsWhatElasticitySaysOfTheseTractions) {
  const Tetrahedra solid = test::boxTetrahedra({8, 6, 4}, {3, 2, 2});
  const TriangleMesh boundary = boundaryOf(solid);
  std::vector<char> fixed;
  for (const Vector3d& p : solid.nodes) fixed.push_back(p.z() < 1e-9);
  Progress progress;
  const Elasticity body(solid, {15, 0.45, 1040}, fixed, progress);
  const TissueResponse response = surfaceResponse(body, boundary, progress);
  std::vector<double> area(solid.nodes.size(), 0);
  std::vector<Vector3d> force(solid.nodes.size(), Vector3d::Zero()), load(body.nodes().position.size(), Vector3d::Zero());
  for (const std::uint32_t node : response.pressed) force[node] = Vector3d(0.3 * node - 5, 2, -0.1 * node);
  const auto sizeOf = [&](std::size_t t) {
    return (boundary.corner(t, 1) - boundary.corner(t, 0)).cross(boundary.corner(t, 2) - boundary.corner(t, 0)).norm() / 2;
  };
  for (std::size_t t = 0; t < boundary.triangles.size(); ++t)
    for (const std::uint32_t node : boundary.triangles[t]) area[node] += sizeOf(t);
  // Visits each point of integration with the hats there and the quadratic nodes of the triangle with their shape
  // functions.
  const auto overBoundary = [&](const auto& visit) {
    for (std::size_t t = 0; t < boundary.triangles.size(); ++t) {
      const Triangle& c = boundary.triangles[t];
      integrate([&](const std::array<double, 3>& l, double weight) {
        std::vector<std::pair<std::uint32_t, double>> shapes;
        for (std::size_t k = 0; k < 3; ++k) {
          shapes.emplace_back(c[k], l[k] * (2 * l[k] - 1));
          shapes.emplace_back(body.nodes().middle(c[k], c[(k + 1) % 3]), 4 * l[k] * l[(k + 1) % 3]);
        }
        visit(c, l, weight * sizeOf(t), shapes);
      });
    }
  };
  overBoundary([&](const Triangle& c, const auto& l, double weight, const auto& shapes) {
    Vector3d traction = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      if (!fixed[c[k]]) traction += l[k] * force[c[k]] / (area[c[k]] / 3);
    for (const auto& [node, value] : shapes) load[node] += weight * value * traction;
  });
  const std::vector<Vector3d> u = body.displacements(load);
  std::vector<Vector3d> mean(solid.nodes.size(), Vector3d::Zero());
  overBoundary([&](const Triangle& c, const auto& l, double weight, const auto& shapes) {
    for (std::size_t k = 0; k < 3; ++k)
      for (const auto& [node, value] : shapes) mean[c[k]] += weight * l[k] / (area[c[k]] / 3) * value * u[node];
  });
  for (std::size_t i = 0; i < response.pressed.size(); ++i) {
    Vector3d found = Vector3d::Zero();
    for (std::size_t k = 0; k < response.pressed.size(); ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t x = 0; x < 3; ++x)
          found[static_cast<Eigen::Index>(x)] +=
              static_cast<double>(response.column(k, axis)[3 * i + x]) * force[response.pressed[k]][static_cast<Eigen::Index>(axis)];
    EXPECT_LT((found - mean[response.pressed[i]]).norm(), 1e-5 * (1 + found.norm()));
  }
}

}  // namespace
}  // namespace spheretree::builder
