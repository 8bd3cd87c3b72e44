// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/tissue/tissue_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <limits>

#include "support/count_allocations.h"
#include "support/random.h"
#include "support/soft_box.h"

namespace spheretree::tissue {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::at;
using test::Field;
using test::isBelow;
using test::noForces;
using test::softBox;

std::unique_ptr<TissueSolver> solverOf(const Tissue& tissue) {
  std::string fault;
  std::unique_ptr<TissueSolver> solver = TissueSolver::make(tissue, fault);
  EXPECT_EQ(fault, "");
  return solver;
}

double volumeOf(const Tissue& tissue, std::span<const Vector3d> u) {
  double sum = 0;
  for (const auto& c : tissue.tetrahedra) {
    const auto p = [&](std::size_t k) { return Vector3d(at(tissue, c[k]) + u[c[k]]); };
    sum += (p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)) / 6;
  }
  return sum;
}

/// Faces of a single tetrahedron, outward.
std::vector<std::array<std::uint32_t, 3>> boundaryOf(const Tissue& tissue) {
  std::vector<std::pair<std::array<std::uint32_t, 3>, std::array<std::uint32_t, 3>>> faces;  // sorted; as it is
  for (const auto& c : tissue.tetrahedra)
    for (const auto& f :
         {std::array{c[1], c[2], c[3]}, std::array{c[0], c[3], c[2]}, std::array{c[0], c[1], c[3]}, std::array{c[0], c[2], c[1]}}) {
      std::array<std::uint32_t, 3> key = f;
      std::sort(key.begin(), key.end());
      faces.emplace_back(key, f);
    }
  std::sort(faces.begin(), faces.end());
  std::vector<std::array<std::uint32_t, 3>> out;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool is_shared =
        (i > 0 && faces[i - 1].first == faces[i].first) || (i + 1 < faces.size() && faces[i + 1].first == faces[i].first);
    if (!is_shared) out.push_back(faces[i].second);
  }
  return out;
}

Matrix3d rotationOf(const Matrix3d& f) {
  const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

// The patch test for large motion: under the boundary forces of a homogeneous deformation it takes that shape, for any
// tetrahedra.
TEST(TissueSolver, TakesEveryEvenShapeUnderItsBoundaryForces) {
  for (const double nu : {0.0, 0.3, 0.45}) {
    const Tissue tissue = softBox({4, 4, 6}, {3, 3, 4}, {15, nu, 1040}, isBelow, 0.2);
    const Vector3d pull(0.1, -0.05, 0.15);
    Matrix3d f = Matrix3d::Identity();
    f.col(2) += pull;
    const double young = 0.015, lambda = young * nu / ((1 + nu) * (1 - 2 * nu)), mu = young / (2 * (1 + nu)), volume = f.determinant();
    const Matrix3d stress = 2 * mu * (f - rotationOf(f)) + lambda * (volume - 1) * volume * f.inverse().transpose();
    Field forces = noForces(tissue);
    for (const auto& t : boundaryOf(tissue)) {
      const Vector3d area = (at(tissue, t[1]) - at(tissue, t[0])).cross(at(tissue, t[2]) - at(tissue, t[0])) / 2;
      for (const std::uint32_t node : t) forces[node] += stress * area / 3;
    }
    const auto solver = solverOf(tissue);
    EXPECT_TRUE(solver->settle(forces, 1e-11, 3000));
    for (std::size_t i = 0; i < tissue.nodes.size(); ++i)
      EXPECT_LT((solver->displacements()[i] - at(tissue, i).z() * pull).norm(), 1e-9) << "node " << i << ", Poisson's ratio " << nu;
  }
}

TEST(TissueSolver, AWholeTurnCostsNothing) {
  const Tissue tissue = softBox({4, 4, 6}, {3, 3, 4}, {15, 0.45, 1040}, isBelow, 0.2);
  const auto solver = solverOf(tissue);
  EXPECT_TRUE(solver->settle(noForces(tissue), 1e-12, 10));
  EXPECT_LT(solver->energy(), 1e-20);
}

// S. P. Timoshenko: the tip of a clamped bar under a force F across it sinks by F L^3 / (3 E I) + F L / (kappa G A).
TEST(TissueSolver, BendsAClampedBarAsBeamTheorySays) {
  const double length = 100, width = 10, height = 8;
  for (const double nu : {0.0, 0.3, 0.45}) {
    const Tissue tissue = softBox({length, width, height}, {40, 4, 4}, {15, nu, 1040}, [](const Vector3d& p) { return p.x() < 1e-9; });
    const double young = 0.015, inertia = width * height * height * height / 12, shear = young / (2 * (1 + nu));
    const double kappa = 10 * (1 + nu) / (12 + 11 * nu), force = 1e-5;
    const double wanted = force * length * length * length / (3 * young * inertia) + force * length / (kappa * shear * width * height);
    Field forces = noForces(tissue);
    std::vector<std::size_t> tip;
    for (std::size_t i = 0; i < forces.size(); ++i)
      if (at(tissue, i).x() > length - 1e-9) tip.push_back(i);
    for (const std::size_t i : tip) forces[i].z() = -force / static_cast<double>(tip.size());
    const auto solver = solverOf(tissue);
    EXPECT_TRUE(solver->settle(forces, 1e-9, 2000));
    double sunk = 0;
    for (const std::size_t i : tip) sunk -= solver->displacements()[i].z() / static_cast<double>(tip.size());
    EXPECT_NEAR(sunk, wanted, 0.03 * wanted) << "Poisson's ratio " << nu;
  }
}

TEST(TissueSolver, ElasticForcesBalanceTheLoadOfLargeMotion) {
  const Tissue tissue = softBox({10, 8, 12}, {4, 3, 5}, {15, 0.45, 1040}, isBelow);
  Field forces = noForces(tissue);
  for (std::size_t i = 0; i < forces.size(); ++i)
    if (at(tissue, i).z() > 11.9) forces[i] = {5e-3, 0, -2e-3};
  const auto solver = solverOf(tissue);
  EXPECT_TRUE(solver->settle(forces, 1e-5, 500));
  const Field elastic = solver->elasticForces();
  Vector3d held = Vector3d::Zero(), load = Vector3d::Zero();
  std::vector<char> fixed(forces.size(), 0);
  for (const std::uint32_t node : tissue.fixed) fixed[node] = 1;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    load += forces[i];
    if (fixed[i])
      held += elastic[i];
    else
      EXPECT_LT((elastic[i] + forces[i]).norm(), 1e-6) << "node " << i;
  }
  EXPECT_LT((held - load).norm(), 1e-5 * load.norm());
  EXPECT_GT(solver->displacements().back().norm(), 2.5) << "this is large motion";
}

TEST(TissueSolver, VolumeIsKeptUnderAPoke) {
  const Tissue tissue = softBox({40, 40, 20}, {10, 10, 5}, {15, 0.45, 1040}, isBelow);
  Field forces = noForces(tissue);
  for (std::size_t i = 0; i < forces.size(); ++i)
    if ((at(tissue, i) - Vector3d(20, 20, 20)).norm() < 5) forces[i].z() = -0.1;
  const auto solver = solverOf(tissue);
  EXPECT_TRUE(solver->settle(forces, 1e-5, 500));
  double deepest = 0;
  for (const Vector3d& u : solver->displacements()) deepest = std::max(deepest, -u.z());
  EXPECT_GT(deepest, 5);
  const double before = volumeOf(tissue, noForces(tissue));
  EXPECT_NEAR(volumeOf(tissue, solver->displacements()), before, 0.01 * before);
}

// 8 iterations are what a player spends on each state.
TEST(TissueSolver, AFewIterationsFollowAForceThatGrows) {
  for (const double nu : {0.45, 0.49}) {
    const Tissue tissue = softBox({40, 40, 20}, {10, 10, 5}, {15, nu, 1040}, isBelow);
    const auto follower = solverOf(tissue), exact = solverOf(tissue);
    Field forces = noForces(tissue);
    double worst = 0, deepest = 0;
    for (int step = 1; step <= 30; ++step) {
      for (std::size_t i = 0; i < forces.size(); ++i)
        if ((at(tissue, i) - Vector3d(20, 20, 20)).norm() < 5) forces[i] = Vector3d(0.02, 0, -0.08) * step / 30;
      EXPECT_TRUE(follower->advance(forces, 8));
    }
    EXPECT_TRUE(exact->settle(forces, 1e-5, 500));
    for (std::size_t i = 0; i < forces.size(); ++i) {
      worst = std::max(worst, (follower->displacements()[i] - exact->displacements()[i]).norm());
      deepest = std::max(deepest, exact->displacements()[i].norm());
    }
    EXPECT_GT(deepest, 3);
    EXPECT_LT(worst, 0.01 * deepest) << nu;
  }
}

TEST(TissueSolver, EnergyOfTheLoadNeverRises) {
  const Tissue tissue = softBox({10, 8, 12}, {4, 3, 5}, {15, 0.45, 1040}, isBelow);
  Field forces = noForces(tissue);
  forces.back() = {0.05, 0.02, -0.05};
  const auto solver = solverOf(tissue);
  double last = 0;
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE(solver->advance(forces, 1));
    double sum = solver->energy();
    for (std::size_t n = 0; n < forces.size(); ++n) sum -= forces[n].dot(solver->displacements()[n]);
    EXPECT_LE(sum, last + 1e-12);
    last = sum;
  }
  EXPECT_LT(last, -1e-3);
}

TEST(TissueSolver, ComesBackFromASqueezeByAThird) {
  const Tissue tissue = softBox({10, 8, 12}, {4, 3, 5}, {15, 0.45, 1040}, isBelow);
  const auto solver = solverOf(tissue);
  Field forces = noForces(tissue);
  for (std::size_t i = 0; i < forces.size(); ++i)
    if (at(tissue, i).z() > 11.9) forces[i].z() = -0.015;
  EXPECT_TRUE(solver->advance(forces, 200));
  EXPECT_LT(solver->displacements().back().z(), -3);
  EXPECT_TRUE(solver->settle(noForces(tissue), 1e-9, 1000));
  for (const Vector3d& u : solver->displacements()) EXPECT_LT(u.norm(), 1e-6);
  EXPECT_LT(solver->energy(), 1e-10);
}

TEST(TissueSolver, TheSameForcesGiveTheSameBytesWithoutAllocation) {
  const Tissue tissue = softBox({10, 8, 12}, {4, 3, 5}, {15, 0.45, 1040}, isBelow);
  Field forces = noForces(tissue);
  forces.back() = {0.05, 0.02, -0.05};
  const auto one = solverOf(tissue), other = solverOf(tissue);
  for (int i = 0; i < 20; ++i) {
    EXPECT_EQ(test::allocationsIn([&] { EXPECT_TRUE(one->advance(forces, 8)); }), 0);
    EXPECT_TRUE(other->advance(forces, 8));
  }
  const Field after(one->displacements().begin(), one->displacements().end());
  EXPECT_TRUE(std::equal(after.begin(), after.end(), other->displacements().begin()));
  one->reset();
  EXPECT_EQ(one->displacements().back(), Vector3d::Zero());
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(one->advance(forces, 8));
  EXPECT_TRUE(std::equal(after.begin(), after.end(), one->displacements().begin())) << "a reset forgets everything";
}

TEST(TissueSolver, AWildForceFreezesItUntilItIsGone) {
  const Tissue tissue = softBox({10, 8, 12}, {4, 3, 5}, {15, 0.45, 1040}, isBelow);
  Field forces = noForces(tissue);
  const auto solver = solverOf(tissue);
  forces.back() = {0.01, 0, 0};
  ASSERT_TRUE(solver->advance(forces, 8));
  const Field before(solver->displacements().begin(), solver->displacements().end());
  forces.back().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solver->advance(forces, 8));
  test::Random random(1);
  for (Vector3d& f : forces) f = random.inCube(1e3);
  EXPECT_FALSE(solver->advance(forces, 8)) << "many tetrahedra would be inside out";
  EXPECT_TRUE(std::equal(before.begin(), before.end(), solver->displacements().begin()));
  for (Vector3d& f : forces) f.setZero();
  EXPECT_TRUE(solver->advance(forces, 8)) << "and goes on";
  EXPECT_TRUE(solver->settle(forces, 1e-9, 500));
  EXPECT_LT(solver->displacements().back().norm(), 1e-6);
}

TEST(TissueSolver, RefusesWhatIsNotHeld) {
  std::string fault;
  const Vector3d size(4, 4, 6);
  EXPECT_EQ(TissueSolver::make(softBox(size, {2, 2, 2}, {15, 0.45, 1040}, [](const Vector3d&) { return false; }), fault), nullptr);
  EXPECT_NE(fault.find("not held"), std::string::npos);
  const auto on_an_edge = [](const Vector3d& p) { return p.y() < 1e-9 && p.z() < 1e-9; };
  EXPECT_EQ(TissueSolver::make(softBox(size, {2, 2, 2}, {15, 0.45, 1040}, on_an_edge), fault), nullptr);
  EXPECT_EQ(TissueSolver::make(softBox(size, {2, 2, 2}, {15, 0.45, 1040}, [](const Vector3d&) { return true; }), fault), nullptr);
  EXPECT_EQ(TissueSolver::make(softBox(size, {2, 2, 2}, {15'000'000, 0.45, 1040}, isBelow), fault), nullptr);
  EXPECT_NE(fault.find("kPa"), std::string::npos);
}

}  // namespace
}  // namespace spheretree::tissue
