// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/elasticity.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <functional>

#include "spheretree/builder/build_settings.h"
#include "support/random.h"
#include "support/tetrahedra.h"

namespace spheretree::builder {
namespace {

using Eigen::Vector3d;

constexpr TissueMaterial kTissue{15, 0.45, 1040};

std::vector<char> fixedWhere(const Tetrahedra& solid, const std::function<bool(const Vector3d&)>& is_fixed) {
  std::vector<char> fixed;
  for (const Vector3d& p : solid.nodes) fixed.push_back(is_fixed(p));
  return fixed;
}

TEST(Elasticity, ReproducesEveryLinearFieldInIrregularTetrahedra) {  // the patch test
  const Vector3d size(4, 3, 5);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    test::Random random(seed);
    Tetrahedra solid = test::boxTetrahedra(size, {6, 5, 6});
    const auto isOuter = [&](const Vector3d& p) { return p.minCoeff() < 1e-9 || (size - p).minCoeff() < 1e-9; };
    const std::vector<char> fixed = fixedWhere(solid, isOuter);
    for (std::size_t i = 0; i < solid.nodes.size(); ++i)
      if (!fixed[i]) solid.nodes[i] += random.inCube(0.08);
    Progress progress;
    const Elasticity body(solid, {random.between(1, 1000), random.between(0, 0.49), 1040}, fixed, progress);
    Eigen::Matrix3d gradient;
    for (int k = 0; k < 3; ++k) gradient.col(k) = random.inCube(0.3);
    const auto field = [&](const Vector3d& p) { return Vector3d(gradient * p + Vector3d(1, -2, 3)); };
    std::vector<Vector3d> given, none(solid.nodes.size(), Vector3d::Zero());
    for (const Vector3d& p : solid.nodes) given.push_back(field(p));
    const std::vector<Vector3d> found = body.displacements(none, given);
    std::size_t inner = 0;
    for (std::uint32_t i = 0; i < found.size(); ++i) {
      inner += !body.isFixed(i);
      EXPECT_LT((found[i] - given[i]).norm(), 1e-9 * given[i].norm()) << "node " << i;
    }
    EXPECT_GT(inner, 50u);
  }
}

// S. P. Timoshenko: the tip of a clamped bar under a force F across it sinks by F L^3 / (3 E I) + F L / (kappa G A).
TEST(Elasticity, BendsAClampedBarAsBeamTheorySays) {
  const double length = 150, width = 10, height = 8, force = 1e-3;
  for (const double nu : {0.0, 0.3, 0.45}) {
    const Tetrahedra solid = test::boxTetrahedra({length, width, height}, {45, 4, 4});
    const double young = 0.015, inertia = width * height * height * height / 12, shear = young / (2 * (1 + nu));
    const double kappa = 10 * (1 + nu) / (12 + 11 * nu);
    const double wanted = force * length * length * length / (3 * young * inertia) + force * length / (kappa * shear * width * height);
    Progress progress;
    const Elasticity body(solid, {1000 * young, nu, 1040}, fixedWhere(solid, [](const Vector3d& p) { return p.x() < 1e-9; }), progress);
    std::vector<Vector3d> forces(solid.nodes.size(), Vector3d::Zero());
    std::vector<std::size_t> tip;
    for (std::size_t i = 0; i < forces.size(); ++i)
      if (solid.nodes[i].x() > length - 1e-9) tip.push_back(i);
    for (const std::size_t i : tip) forces[i].z() = -force / static_cast<double>(tip.size());
    const std::vector<Vector3d> found = body.displacements(forces);
    double sunk = 0;
    for (const std::size_t i : tip) sunk -= found[i].z() / static_cast<double>(tip.size());
    EXPECT_NEAR(sunk, wanted, 0.03 * wanted) << "Poisson's ratio " << nu;
  }
}

TEST(Elasticity, ManyRightHandSidesAreAsOne) {
  const Tetrahedra solid = test::boxTetrahedra({3, 2, 2}, {3, 2, 2});
  Progress progress;
  const Elasticity body(solid, kTissue, fixedWhere(solid, [](const Vector3d& p) { return p.z() < 1e-9; }), progress);
  const auto rows = static_cast<Eigen::Index>(body.unknowns());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> columns = Eigen::MatrixXd::Zero(rows, 5);
  test::Random random(3);
  std::vector<std::vector<Vector3d>> forces(5, std::vector<Vector3d>(solid.nodes.size(), Vector3d::Zero()));
  for (std::size_t c = 0; c < 5; ++c)
    for (std::uint32_t i = 0; i < forces[c].size(); ++i) {
      if (body.isFixed(i)) continue;
      forces[c][i] = random.inCube(1);
      columns.block<3, 1>(body.unknown(i), static_cast<Eigen::Index>(c)) = forces[c][i];
    }
  body.solve(columns);
  for (std::size_t c = 0; c < 5; ++c) {
    const std::vector<Vector3d> one = body.displacements(forces[c]);
    for (std::uint32_t i = 0; i < one.size(); ++i) {
      if (body.isFixed(i)) {
        EXPECT_EQ(one[i], Vector3d::Zero());
        continue;
      }
      EXPECT_LT((columns.block<3, 1>(body.unknown(i), static_cast<Eigen::Index>(c)) - one[i]).norm(), 1e-9 * (1 + one[i].norm()));
    }
  }
}

TEST(Elasticity, RefusesWhatIsNotHeld) {
  const Tetrahedra solid = test::boxTetrahedra({3, 2, 2}, {3, 2, 2});
  Progress progress;
  EXPECT_THROW(Elasticity(solid, kTissue, std::vector<char>(solid.nodes.size(), 0), progress), BuildError);
  const auto on_an_edge = [](const Vector3d& p) { return p.y() < 1e-9 && p.z() < 1e-9; };  // three and more, in line
  EXPECT_THROW(Elasticity(solid, kTissue, fixedWhere(solid, on_an_edge), progress), BuildError);
  EXPECT_THROW(Elasticity(solid, kTissue, std::vector<char>(solid.nodes.size(), 1), progress), BuildError);
}

}  // namespace
}  // namespace spheretree::builder
