// SPDX-License-Identifier: GPL-3.0-or-later
#include "smoothed_elements.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

#include "spheretree/tissue/rest_stiffness.h"
#include "support/soft_box.h"

namespace spheretree::tissue {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::Field;

struct Smoothed {
  Tissue tissue;
  SmoothedElements elements;
  Field gradient;

  explicit Smoothed(double nu = 0.45, std::array<std::uint32_t, 3> cells = {2, 2, 2})
      : tissue(test::softBox({4, 3, 5}, cells, {15, nu, 1040}, test::isBelow, 0.3)), elements(tissue), gradient(test::noForces(tissue)) {}
  double energy(const Field& u) { return elements.energy(u, gradient); }
  Field displaced(const Matrix3d& f) const {
    Field u;
    for (std::size_t i = 0; i < tissue.nodes.size(); ++i) u.push_back(f * test::at(tissue, i) - test::at(tissue, i));
    return u;
  }
  Field noise(test::Random& random, double size) const {
    Field u;
    for (std::size_t i = 0; i < tissue.nodes.size(); ++i) u.push_back(random.inCube(size));
    return u;
  }
};

Matrix3d randomTurn(test::Random& random, double angle) { return Eigen::AngleAxisd(angle, random.direction()).toRotationMatrix(); }

Matrix3d nearestRotation(const Matrix3d& f) {
  const Eigen::JacobiSVD<Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

// Per volume: mu |F - R|^2 + lambda / 2 (J - 1)^2, and 10 (lambda + 2 mu) / 2 (0.3 - J)^2 where J < 0.3.
TEST(SmoothedElements, AnEvenDeformationHasTheEnergyOfTheMaterial) {
  test::Random random(1);
  int flat = 0;
  for (const double nu : {0.0, 0.45})
    for (int n = 0; n < 40; ++n) {
      Smoothed box(nu);
      Matrix3d stretch = Vector3d(random.between(0.2, 1.5), random.between(0.7, 1.5), random.between(0.7, 1.5)).asDiagonal();
      const Matrix3d axes = randomTurn(random, 1), f = randomTurn(random, random.between(0, 1.2)) * axes * stretch * axes.transpose();
      const double young = 0.015, lambda = young * nu / ((1 + nu) * (1 - 2 * nu)), mu = young / (2 * (1 + nu)), ratio = f.determinant();
      const double lack = std::max(0.0, 0.3 - ratio);
      flat += lack > 0;
      const double wanted =
          60 * (mu * (f - nearestRotation(f)).squaredNorm() + lambda / 2 * (ratio - 1) * (ratio - 1) + 5 * (lambda + 2 * mu) * lack * lack);
      EXPECT_NEAR(box.energy(box.displaced(f)), wanted, 1e-9 * wanted) << "stretches " << stretch.diagonal().transpose();
      EXPECT_NEAR(box.elements.mu(), mu, 1e-15);
    }
  EXPECT_GT(flat, 2) << "some have less than 30 % of their volume";
}

TEST(SmoothedElements, ARigidMotionCostsNothingAtAnyAngle) {
  Smoothed box;
  const Vector3d axis = Vector3d(1, -2, 0.5).normalized();
  for (double angle = 0; angle < 7; angle += 0.2) {  // more than a whole turn
    Field u = box.displaced(Eigen::AngleAxisd(angle, axis).toRotationMatrix());
    for (Vector3d& x : u) x += Vector3d(5, 6, -7);
    EXPECT_LT(box.energy(u), 1e-20) << angle;
    for (const Vector3d& g : box.gradient) EXPECT_LT(g.norm(), 1e-12) << angle;
  }
}

TEST(SmoothedElements, TheGradientIsTheDerivativeOfTheEnergy) {
  test::Random random(2);
  for (const double size : {0.02, 0.3, 1.0}) {  // the last with inverted tetrahedra
    Smoothed box;
    const Field u = box.noise(random, size);
    EXPECT_EQ(box.elements.inverted(u) > 0, size == 1.0);
    const double energy = box.energy(u);
    const Field gradient = box.gradient;
    double largest = 0;
    for (const Vector3d& g : gradient) largest = std::max(largest, g.norm());
    for (int n = 0; n < 20; ++n) {
      const Field way = box.noise(random, 1);
      constexpr double h = 1e-5;
      Field plus = u, minus = u;
      double slope = 0;
      for (std::size_t i = 0; i < u.size(); ++i) plus[i] += h * way[i], minus[i] -= h * way[i], slope += gradient[i].dot(way[i]);
      EXPECT_NEAR((box.energy(plus) - box.energy(minus)) / (2 * h), slope, 1e-5 * largest) << "size " << size << ", energy " << energy;
    }
  }
}

TEST(SmoothedElements, NearRestTheGradientIsTheStiffnessAtRest) {
  test::Random random(3);
  for (const double nu : {0.0, 0.45}) {
    Smoothed box(nu);
    Field nodes;
    for (std::size_t i = 0; i < box.tissue.nodes.size(); ++i) nodes.push_back(test::at(box.tissue, i));
    const Eigen::SparseMatrix<double> stiffness = restStiffness(nodes, box.tissue.tetrahedra, box.tissue.material);
    const Field u = box.noise(random, 1e-6);
    box.energy(u);
    const auto flat = [](const Field& field) {
      return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(field[0].data(), 3 * std::ssize(field)));
    };
    const Eigen::VectorXd wanted = stiffness * flat(u);
    EXPECT_LT((flat(box.gradient) - wanted).norm(), 1e-5 * wanted.norm()) << "the rest is of second order";
  }
}

TEST(SmoothedElements, TheForcesOfAnyStateBalanceEachOther) {
  test::Random random(4);
  Smoothed box;
  for (int n = 0; n < 10; ++n) {
    const Field u = box.noise(random, 1);
    box.energy(u);
    Vector3d force = Vector3d::Zero(), torque = Vector3d::Zero();
    double size = 0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      force += box.gradient[i];
      torque += (test::at(box.tissue, i) + u[i]).cross(box.gradient[i]);
      size += box.gradient[i].norm();
    }
    EXPECT_LT(force.norm(), 1e-12 * size);
    EXPECT_LT(torque.norm(), 1e-4 * size) << "exact up to the tolerance of the rotations";
  }
}

TEST(SmoothedElements, CountsInvertedTetrahedra) {
  test::Random random(5);
  Smoothed box;
  EXPECT_EQ(box.elements.elements().size(), 48u);
  EXPECT_EQ(box.elements.inverted(test::noForces(box.tissue)), 0u);
  EXPECT_EQ(box.elements.inverted(box.displaced(-Matrix3d::Identity())), 48u);
  double volume = 0;
  for (const Element& e : box.elements.elements()) volume += e.volume;
  EXPECT_NEAR(volume, 60, 1e-12);
  std::size_t all = 0;
  for (int n = 0; n < 20; ++n) {
    const Field u = box.noise(random, 1);
    std::size_t wanted = 0;
    for (const auto& c : box.tissue.tetrahedra) {
      const auto p = [&](std::size_t k) { return Vector3d(test::at(box.tissue, c[k]) + u[c[k]]); };
      wanted += !((p(1) - p(0)).cross(p(2) - p(0)).dot(p(3) - p(0)) > 0);
    }
    EXPECT_EQ(box.elements.inverted(u), wanted);
    all += wanted;
  }
  EXPECT_GT(all, 20u);
}

TEST(SmoothedElements, AResetGivesTheSameBytesAgain) {
  test::Random random(6);
  Smoothed box;
  std::vector<Field> states;
  for (int n = 0; n < 5; ++n) states.push_back(box.noise(random, 3));  // inverted: rotations are not unique
  std::vector<double> first;
  for (const Field& u : states) first.push_back(box.energy(u));
  const Field gradient = box.gradient;
  EXPECT_NE(box.energy(states[0]), first[0]) << "the rotations start from those of the last state";
  box.elements.reset();
  for (std::size_t n = 0; n < states.size(); ++n) EXPECT_EQ(box.energy(states[n]), first[n]);
  EXPECT_EQ(box.gradient, gradient);
}

}  // namespace
}  // namespace spheretree::tissue
