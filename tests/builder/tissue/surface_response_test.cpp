// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/surface_response.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "spheretree/tissue/tissue_solver.h"
#include "support/random.h"
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

// Against elasticity itself: all forces together.
TEST(SurfaceResponse, AgreesWithElasticityForForcesOnNodes) {
  const Tetrahedra solid = test::boxTetrahedra({8, 6, 4}, {3, 2, 2});
  std::vector<char> fixed;
  for (const Vector3d& p : solid.nodes) fixed.push_back(p.z() < 1e-9);
  Progress progress;
  const Elasticity body(solid, {15, 0.45, 1040}, fixed, progress);
  const TissueResponse response = surfaceResponse(body, boundaryOf(solid), progress);
  std::vector<Vector3d> force(solid.nodes.size(), Vector3d::Zero());
  for (const std::uint32_t node : response.pressed) force[node] = Vector3d(0.3 * node - 5, 2, -0.1 * node);
  const std::vector<Vector3d> wanted = body.displacements(force);
  for (std::size_t i = 0; i < response.pressed.size(); ++i) {
    Vector3d found = Vector3d::Zero();
    for (std::size_t k = 0; k < response.pressed.size(); ++k)
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (std::size_t x = 0; x < 3; ++x)
          found[static_cast<Eigen::Index>(x)] +=
              static_cast<double>(response.column(k, axis)[3 * i + x]) * force[response.pressed[k]][static_cast<Eigen::Index>(axis)];
    EXPECT_LT((found - wanted[response.pressed[i]]).norm(), 1e-5 * (1 + found.norm()));
  }
}

// Small and large motion describe the same tissue: that of the solver, under forces that hardly move it.
TEST(SurfaceResponse, IsTheSolverUnderSmallForces) {
  const Tetrahedra solid = test::boxTetrahedra({8, 6, 4}, {4, 3, 2});
  Tissue tissue;
  tissue.material = {15, 0.45, 1040};
  std::vector<char> fixed;
  for (const Vector3d& p : solid.nodes) {
    fixed.push_back(p.z() < 1e-9);
    if (fixed.back()) tissue.fixed.push_back(static_cast<std::uint32_t>(tissue.nodes.size()));
    tissue.nodes.push_back({p.x(), p.y(), p.z()});
  }
  tissue.tetrahedra = solid.corners;
  tissue.surface.push_back({tissue.nodes[0], 0, {1, 0, 0}});
  std::string fault;
  const auto solver = tissue::TissueSolver::make(tissue, fault);
  ASSERT_TRUE(solver) << fault;
  Progress progress;
  const Elasticity body(solid, tissue.material, fixed, progress);
  std::vector<Vector3d> force(solid.nodes.size(), Vector3d::Zero());
  test::Random random(5);
  for (Vector3d& f : force) f = random.inCube(1e-6);
  const std::vector<Vector3d> wanted = body.displacements(force);
  ASSERT_TRUE(solver->settle(force, 1e-12, 500));
  double largest = 0, off = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    largest = std::max(largest, wanted[i].norm());
    off = std::max(off, (solver->displacements()[i] - wanted[i]).norm());
  }
  EXPECT_GT(largest, 1e-6);
  EXPECT_LT(off, 1e-3 * largest);
}

}  // namespace
}  // namespace spheretree::builder
