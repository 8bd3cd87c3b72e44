// SPDX-License-Identifier: GPL-3.0-or-later
#include "spheretree/tissue/rest_stiffness.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <map>
#include <utility>

#include "support/soft_box.h"

namespace spheretree::tissue {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct StiffBox {
  Tissue tissue;
  test::Field nodes;
  MatrixXd stiffness;

  explicit StiffBox(const TissueMaterial& material) : tissue(test::softBox({4, 3, 5}, {2, 2, 2}, material, test::isBelow, 0.3)) {
    for (std::size_t i = 0; i < tissue.nodes.size(); ++i) nodes.push_back(test::at(tissue, i));
    stiffness = MatrixXd(restStiffness(nodes, tissue.tetrahedra, material));
  }
  /// One displacement after the other, `u` of the place of each node.
  template <class Displacement>
  VectorXd field(const Displacement& u) const {
    VectorXd out(static_cast<Eigen::Index>(3 * nodes.size()));
    for (std::size_t i = 0; i < nodes.size(); ++i) out.segment<3>(static_cast<Eigen::Index>(3 * i)) = u(nodes[i]);
    return out;
  }
  double lambda() const {
    const double nu = tissue.material.poisson;
    return tissue.material.young_kpa / 1000 * nu / ((1 + nu) * (1 - 2 * nu));
  }
  double mu() const { return tissue.material.young_kpa / 2000 / (1 + tissue.material.poisson); }
};

const std::vector<TissueMaterial> kMaterials{{15, 0, 1040}, {15, 0.3, 1040}, {2000, 0.45, 1040}};

TEST(RestStiffness, OnlyRigidMotionsAreFree) {
  for (const TissueMaterial& material : kMaterials) {
    const StiffBox box(material);
    const double largest = box.stiffness.cwiseAbs().maxCoeff();
    EXPECT_LT((box.stiffness - box.stiffness.transpose()).cwiseAbs().maxCoeff(), 1e-14 * largest);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d e = Vector3d::Unit(axis);
      EXPECT_LT((box.stiffness * box.field([&](const Vector3d&) { return e; })).cwiseAbs().maxCoeff(), 1e-12 * largest);
      EXPECT_LT((box.stiffness * box.field([&](const Vector3d& p) { return Vector3d(e.cross(p)); })).cwiseAbs().maxCoeff(),
                1e-12 * largest);
    }
    const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(box.stiffness).eigenvalues();
    EXPECT_LT(std::abs(values[5]), 1e-12 * largest) << "six rigid motions";
    EXPECT_GT(values[6], 1e-4 * largest) << "every other motion meets resistance; ascending from 4e-3 of the largest";
  }
}

// The patch test: an even strain E has the energy V (mu |E|^2 + lambda / 2 (tr E)^2), for any tetrahedra.
TEST(RestStiffness, AnEvenStrainHasTheEnergyOfTheMaterial) {
  test::Random random(1);
  for (const TissueMaterial& material : kMaterials) {
    const StiffBox box(material);
    for (int n = 0; n < 10; ++n) {
      Matrix3d map;
      for (double& x : map.reshaped()) x = random.between(-1, 1);
      const Matrix3d strain = 0.5 * (map + map.transpose());
      const VectorXd u = box.field([&](const Vector3d& p) { return Vector3d(map * p); });
      const double wanted = 4 * 3 * 5 * (box.mu() * strain.squaredNorm() + box.lambda() / 2 * strain.trace() * strain.trace());
      EXPECT_NEAR(u.dot(box.stiffness * u) / 2, wanted, 1e-12 * wanted);
    }
  }
}

// The sums of the header, with gradients from the shape functions of each tetrahedron and no matrix at all.
TEST(RestStiffness, EnergyIsTheSumOverEdgesAndNodes) {
  test::Random random(2);
  for (const TissueMaterial& material : kMaterials) {
    const StiffBox box(material);
    for (int n = 0; n < 5; ++n) {
      const VectorXd u = box.field([&](const Vector3d&) { return random.inCube(1); });
      struct Mean {
        double volume = 0;
        Matrix3d sum = Matrix3d::Zero();
      };
      std::map<std::pair<std::uint32_t, std::uint32_t>, Mean> edges;
      std::vector<Mean> nodes(box.nodes.size());
      for (const auto& c : box.tissue.tetrahedra) {
        Matrix3d rest, moved;
        for (int k = 0; k < 3; ++k) {
          const std::uint32_t node = c[static_cast<std::size_t>(k) + 1];
          rest.col(k) = box.nodes[node] - box.nodes[c[0]];
          moved.col(k) = u.segment<3>(3 * Eigen::Index{node}) - u.segment<3>(3 * Eigen::Index{c[0]});
        }
        const double volume = rest.determinant() / 6;
        const auto add = [&](Mean& mean, double share) {
          mean.volume += share * volume, mean.sum += share * volume * moved * rest.inverse();
        };
        for (std::size_t a = 0; a < 4; ++a) {
          add(nodes[c[a]], 1.0 / 4);
          for (std::size_t b = a + 1; b < 4; ++b) add(edges[std::minmax(c[a], c[b])], 1.0 / 6);
        }
      }
      double energy = 0;
      for (const auto& [ends, mean] : edges) energy += box.mu() / mean.volume * (mean.sum + mean.sum.transpose()).squaredNorm() / 4;
      for (const Mean& mean : nodes) energy += box.lambda() / 2 / mean.volume * mean.sum.trace() * mean.sum.trace();
      EXPECT_NEAR(u.dot(box.stiffness * u) / 2, energy, 1e-12 * energy);
    }
  }
}

TEST(RestStiffness, GrowsWithTheModulusAndTheSize) {
  const StiffBox box({15, 0.45, 1040});
  const double largest = box.stiffness.cwiseAbs().maxCoeff();
  test::Field twice = box.nodes;
  for (Vector3d& p : twice) p *= 2;
  const MatrixXd stiffer(restStiffness(box.nodes, box.tissue.tetrahedra, {45, 0.45, 1040})),
      larger(restStiffness(twice, box.tissue.tetrahedra, {15, 0.45, 1040}));
  EXPECT_LT((stiffer - 3 * box.stiffness).cwiseAbs().maxCoeff(), 1e-13 * largest);
  EXPECT_LT((larger - 2 * box.stiffness).cwiseAbs().maxCoeff(), 1e-13 * largest) << "N/mm: one power of the length";
}

}  // namespace
}  // namespace spheretree::tissue
