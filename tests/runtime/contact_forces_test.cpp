// SPDX-License-Identifier: GPL-3.0-or-later
// Subject: contact_forces.h
#include "contact/contact_forces.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "support/random.h"

namespace spheretree::runtime {
namespace {

using test::Random;

struct ForceProblem {
  ContactQp qp;
  SurfaceCompliance compliance{};
};

/// Contacts of a tool that is pressed and dragged, on a surface that they move in `ways` ways; 0: it is rigid.
std::unique_ptr<ForceProblem> randomProblem(Random& random, int contacts, int ways, bool has_law) {
  auto out = std::make_unique<ForceProblem>();
  ContactQp& qp = out->qp;
  qp.row_count = qp.disc_count = contacts;
  qp.target << random.between(-1, 1), random.between(-1, 1), -random.between(0.5, 2), 0.3 * random.between(-1, 1), 0, 0;
  qp.tolerance = 1e-6;
  std::array<std::array<double, 12>, kMaxForces> factor{};
  for (std::size_t k = 0; k < static_cast<std::size_t>(contacts); ++k) {
    const Eigen::Vector3d n = (Eigen::Vector3d(0, 0, 1) + 0.5 * random.inCube(1)).normalized(), arm = random.inCube(1),
                          t0 = n.unitOrthogonal(), t1 = n.cross(t0);
    qp.rows[k].a << n, arm.cross(n);
    qp.rows[k].b = random.between(-0.3, 0);
    FrictionDisc& disc = qp.discs[k];
    disc.across[0] << t0, arm.cross(t0);
    disc.across[1] << t1, arm.cross(t1);
    for (double& origin : disc.origin) origin = random.between(-0.1, 0.1);
    disc.row = static_cast<int>(k);
    const double mu = random.between(0.05, 1);
    (has_law ? disc.law : disc.radius) = has_law ? mu : 0.5 * mu;
    for (const std::size_t i : {k, forceOf(k, 0), forceOf(k, 1)})
      for (int m = 0; m < ways; ++m) factor[i][static_cast<std::size_t>(m)] = random.between(-2, 2);
  }
  for (std::size_t i = 0; i < kMaxForces; ++i)
    for (std::size_t j = 0; j < kMaxForces; ++j)
      for (std::size_t m = 0; m < 12; ++m) out->compliance[i][j] += factor[i][m] * factor[j][m];
  return out;
}

/// By how much an answer breaks the law, from the tool's motion and the forces alone [mm].
double faultOf(const ForceProblem& p) {
  const ContactQp& qp = p.qp;
  Vector6 y = qp.target;
  const auto contacts = static_cast<std::size_t>(qp.row_count);
  for (std::size_t k = 0; k < contacts; ++k)
    y += qp.rows[k].multiplier * qp.rows[k].a + qp.discs[k].force[0] * qp.discs[k].across[0] + qp.discs[k].force[1] * qp.discs[k].across[1];
  double largest = (y - qp.y).norm();
  const auto given = [&](std::size_t i) {
    double sum = 0;
    for (std::size_t k = 0; k < contacts; ++k) {
      sum += p.compliance[i][k] * qp.rows[k].multiplier;
      for (std::size_t axis = 0; axis < 2; ++axis) sum += p.compliance[i][forceOf(k, axis)] * qp.discs[k].force[axis];
    }
    return sum;
  };
  for (std::size_t k = 0; k < contacts; ++k) {
    const double w = qp.rows[k].a.dot(y) + given(k) - qp.rows[k].b, u = qp.rows[k].multiplier;
    largest = std::max({largest, -w, -u, std::min(u, w)});
    const FrictionDisc& d = qp.discs[k];
    const Eigen::Vector2d f(d.force[0], d.force[1]),
        v(d.across[0].dot(y) + given(forceOf(k, 0)) - d.origin[0], d.across[1].dot(y) + given(forceOf(k, 1)) - d.origin[1]);
    const double radius = d.law > 0 ? d.law * u : d.radius;
    largest = std::max(largest, f.norm() - radius);
    if (v.norm() > 1e-4) largest = std::max(largest, (f + radius * v / v.norm()).norm() * std::min(1.0, v.norm()));
    if (f.norm() < radius * (1 - 1e-6) - 1e-5) largest = std::max(largest, v.norm());
  }
  return largest;
}

struct LawCase {
  int contacts;
  double converged, iterations;  // smallest share, and largest mean
};

class ContactForcesLaw : public testing::TestWithParam<LawCase> {};

TEST_P(ContactForcesLaw, IsObeyedOnTissue) {
  Random random(1);
  int converged = 0;
  double iterations = 0;
  constexpr int kRuns = 3000;
  for (int run = 0; run < kRuns; ++run) {
    const auto p = randomProblem(random, 1 + run % GetParam().contacts, 12, true);
    solveForces(p->qp, p->compliance);
    for (int d = 0; d < p->qp.disc_count; ++d) {
      const FrictionDisc& disc = p->qp.discs[static_cast<std::size_t>(d)];
      ASSERT_LE(std::hypot(disc.force[0], disc.force[1]),
                disc.law * p->qp.rows[static_cast<std::size_t>(disc.row)].multiplier * (1 + 1e-9) + 1e-12)
          << "in its cone, converged or not";
    }
    iterations += p->qp.iterations;
    if (!p->qp.converged) continue;
    ++converged;
    ASSERT_LT(faultOf(*p), 2e-5) << run;
  }
  EXPECT_GE(converged, GetParam().converged * kRuns);
  EXPECT_LT(iterations / kRuns, GetParam().iterations);
}
INSTANTIATE_TEST_SUITE_P(FewAndAll, ContactForcesLaw, testing::Values(LawCase{10, 0.999, 3}, LawCase{kMaxContactRows, 0.99, 5}));

// With the forces of the discs held, the multipliers are those of a problem without friction, under these forces.
TEST(ContactForces, HeldFrictionIsALoad) {
  Random random(4);
  for (int run = 0; run < 500; ++run) {
    const auto p = randomProblem(random, 1 + run % 8, 12, true);
    ContactQp& qp = p->qp;
    auto loaded = std::make_unique<ForceProblem>(*p);
    loaded->qp.disc_count = 0;
    for (std::size_t d = 0; d < static_cast<std::size_t>(qp.disc_count); ++d)
      for (std::size_t axis = 0; axis < 2; ++axis) {
        const double f = qp.discs[d].force[axis] = random.between(-0.2, 0.2);
        loaded->qp.target += f * qp.discs[d].across[axis];
        for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k)
          loaded->qp.rows[k].b -= f * p->compliance[k][forceOf(d, axis)];
      }
    qp.holds_friction = true;
    solveForces(qp, p->compliance);
    solveForces(loaded->qp, p->compliance);
    ASSERT_TRUE(qp.converged && loaded->qp.converged) << run;
    ASSERT_LT((qp.y - loaded->qp.y).norm(), 1e-8) << run;
    for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k)
      ASSERT_NEAR(qp.rows[k].multiplier, loaded->qp.rows[k].multiplier, 1e-6) << run;
  }
}

// Where the radii of the discs are given the problem is convex, and has one answer: that of the other solver.
TEST(ContactForces, AgreesWithTheProblemInCoordinates) {
  Random random(2);
  int converged = 0;
  for (int run = 0; run < 2000; ++run) {
    const auto p = randomProblem(random, 1 + run % 3, 0, false);
    auto other = std::make_unique<ContactQp>(p->qp);
    solveForces(p->qp, p->compliance);
    other->tolerance = 1e-9;
    solveContactQp(*other);
    ASSERT_TRUE(other->converged);
    if (!p->qp.converged) continue;
    ++converged;
    ASSERT_LT((p->qp.y - other->y).norm(), 1e-5) << run;
  }
  EXPECT_GT(converged, 1900);
}

TEST(ContactForces, TheAnswerAsAGuessIsFoundAtOnce) {
  Random random(3);
  for (int run = 0; run < 500; ++run) {
    const auto p = randomProblem(random, 1 + run % 8, 12, true);
    solveForces(p->qp, p->compliance);
    if (!p->qp.converged) continue;
    const Vector6 y = p->qp.y;
    solveForces(p->qp, p->compliance);
    ASSERT_LE(p->qp.iterations, 2) << run;
    ASSERT_LT((p->qp.y - y).norm(), 1e-5);
  }
}

TEST(ContactForces, WithoutDiscsRowsAndTissueAreSpringsInSeries) {
  ForceProblem p{};
  p.qp.target << 0, 0, -1, 0, 0, 0;
  p.qp.row_count = 1;
  p.qp.rows[0].a << 0, 0, 1, 0, 0, 0;
  p.compliance[0][0] = 3;
  solveForces(p.qp, p.compliance);
  EXPECT_TRUE(p.qp.converged);
  EXPECT_NEAR(p.qp.rows[0].multiplier, 0.25, 1e-8);
  EXPECT_NEAR(p.qp.y[2], -0.75, 1e-8);
}

}  // namespace
}  // namespace spheretree::runtime
