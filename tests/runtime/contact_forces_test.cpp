// SPDX-License-Identifier: Apache-2.0
// Subject: contact_forces.h
#include "contact/contact_forces.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "contact/contact_system.h"
#include "contact/proximal_point.h"
#include "support/random.h"

namespace spheretree::runtime {
namespace {

using test::Random;

constexpr std::uint32_t kWork = 2'000'000;

Vector6 randomVector(Random& random, double half) {
  Vector6 v;
  for (int k = 0; k < 6; ++k) v[k] = random.between(-half, half);
  return v;
}

// Rows that all allow one step, some of them in groups that yield, and discs of given radii. Every tenth problem has
// dependent rows.
ContactProblem convexProblem(Random& random, int run) {
  ContactProblem qp;
  const Vector6 free = randomVector(random, 0.5);
  qp.target = randomVector(random, 2);
  qp.row_count = static_cast<int>(random.between(0, 10));
  qp.group_count = run % 3 == 0 ? 2 : 0;
  for (int g = 0; g < qp.group_count; ++g) qp.rest[static_cast<std::size_t>(g)] = random.between(-0.1, 0.1);
  for (int k = 0; k < qp.row_count; ++k) {
    ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
    row.a = randomVector(random, 1).normalized();
    if (run % 10 == 0 && k > 0) row.a = qp.rows[0].a;
    row.b = row.a.dot(free) - random.between(0, 0.5);
    if (run % 10 == 0 && k > 0) row.b = qp.rows[0].b;
    if (qp.group_count > 0 && k % 3 == 0) {
      row.group = k % 2;
      row.give = random.between(0.1, 2);
    }
  }
  qp.disc_count = static_cast<int>(random.between(0, 6));
  for (int k = 0; k < qp.disc_count; ++k) {
    FrictionDisc& disc = qp.discs[static_cast<std::size_t>(k)];
    for (Vector6& t : disc.across) t = randomVector(random, 1);
    disc.radius = random.between(0, 1) * random.between(0, 1.5);
    if (run % 4 == 0) disc.origin = {random.between(-0.1, 0.1), random.between(-0.1, 0.1)};
  }
  return qp;
}

double givenPart(const ContactProblem& qp, int k) {
  const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
  return row.group < 0 ? 0 : row.give * qp.given[static_cast<std::size_t>(row.group)];
}

double lacks(const ContactProblem& qp, int k) {
  const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
  return row.b - row.a.dot(qp.y) - givenPart(qp, k);
}

// A bound on the distance of an answer from the solution: the gap between a value that the answer reaches and one that
// no feasible point can undercut, by forces that the laws of friction and contact allow (weak duality); the problem is
// strongly convex. The bound holds for any method.
double distanceFromRight(const ContactProblem& qp) {
  double primal = 0.5 * (qp.y - qp.target).squaredNorm(), dual = 0;
  Vector6 pull = Vector6::Zero();
  std::array<double, kMaxGroups> group_pull{};
  for (int g = 0; g < qp.group_count; ++g) {
    const auto at = static_cast<std::size_t>(g);
    primal += 0.5 * (qp.given[at] - qp.rest[at]) * (qp.given[at] - qp.rest[at]);
  }
  const auto press = [&](int k, double u) {
    const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
    pull += u * row.a;
    if (row.group >= 0) group_pull[static_cast<std::size_t>(row.group)] += u * row.give;
  };
  for (int k = 0; k < qp.row_count; ++k) {
    const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
    const double u = row.multiplier;
    EXPECT_GE(u, 0);
    const double lack = lacks(qp, k);
    EXPECT_LT(lack, 2e-8);
    press(k, u);
    dual += u * row.b;
  }
  for (int k = 0; k < qp.disc_count; ++k) {
    const FrictionDisc& disc = qp.discs[static_cast<std::size_t>(k)];
    const double slip = std::hypot(disc.across[0].dot(qp.y) - disc.origin[0], disc.across[1].dot(qp.y) - disc.origin[1]);
    EXPECT_LE(std::hypot(disc.force[0], disc.force[1]), disc.radius * (1 + 1e-9) + 1e-12);
    primal += disc.radius * slip;
    for (std::size_t i = 0; i < 2; ++i) {
      pull += disc.force[i] * disc.across[i];
      dual += disc.force[i] * disc.origin[i];
    }
  }
  // The minimum of |y - t|^2 / 2 - pull . y over all y.
  dual += -0.5 * pull.squaredNorm() - pull.dot(qp.target);
  for (int g = 0; g < qp.group_count; ++g) {
    const auto at = static_cast<std::size_t>(g);
    dual += -0.5 * group_pull[at] * group_pull[at] - group_pull[at] * qp.rest[at];
  }
  return std::sqrt(2 * std::max(0.0, primal - dual));
}

// A slow independent solver: each multiplier or force in turn is optimised with the others fixed.
class SlowSolver {
 public:
  explicit SlowSolver(const ContactProblem& qp) : qp_(qp), y_(qp.target), given_(qp.rest) {}
  Vector6 answer(int sweeps) {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      double change = 0;
      for (int k = 0; k < qp_.row_count; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const double by = std::max(-u_[at], lack(k) / size(k));
        u_[at] += by;
        press(k, by);
        change = std::max(change, std::abs(by));
      }
      for (int d = 0; d < qp_.disc_count; ++d) change = std::max(change, rub(d));
      if (change < 1e-14) break;
    }
    return y_;
  }

 private:
  double lack(int k) const {
    const ContactRow& row = qp_.rows[static_cast<std::size_t>(k)];
    return row.b - row.a.dot(y_) - row.give * (row.group < 0 ? 0 : given_[static_cast<std::size_t>(row.group)]);
  }
  double size(int k) const {
    const ContactRow& row = qp_.rows[static_cast<std::size_t>(k)];
    return row.a.squaredNorm() + row.give * row.give;
  }
  void press(int k, double by) {
    const ContactRow& row = qp_.rows[static_cast<std::size_t>(k)];
    y_ += by * row.a;
    if (row.group >= 0) given_[static_cast<std::size_t>(row.group)] += by * row.give;
  }
  double rub(int d) {
    const auto at = static_cast<std::size_t>(d);
    const FrictionDisc& disc = qp_.discs[at];
    const double all = disc.across[0].squaredNorm() + disc.across[1].squaredNorm();
    std::array<double, 2> next = force_[at];
    for (std::size_t i = 0; i < 2; ++i) next[i] -= (disc.across[i].dot(y_) - disc.origin[i]) / all;
    const double length = std::hypot(next[0], next[1]), shrink = length > disc.radius ? disc.radius / length : 1;
    double change = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      const double by = shrink * next[i] - force_[at][i];
      force_[at][i] += by;
      y_ += by * disc.across[i];
      change = std::max(change, std::abs(by));
    }
    return change;
  }

  const ContactProblem& qp_;
  Vector6 y_;
  std::array<double, kMaxGroups> given_;
  std::array<double, kMaxContactRows> u_{};
  std::array<std::array<double, 2>, kMaxContactRows> force_{};
};

struct ForceProblem {
  ContactProblem qp;
  SurfaceCompliance compliance{};
};

/// Contacts of a tool that is pressed and dragged, on a surface that they move in `ways` ways; 0: it is rigid.
std::unique_ptr<ForceProblem> randomProblem(Random& random, int contacts, int ways, bool has_law) {
  auto out = std::make_unique<ForceProblem>();
  ContactProblem& qp = out->qp;
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
    (has_law ? disc.friction : disc.radius) = has_law ? mu : 0.5 * mu;
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
  const ContactProblem& qp = p.qp;
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
    const double radius = d.friction > 0 ? d.friction * u : d.radius;
    largest = std::max(largest, f.norm() - radius);
    if (v.norm() > 1e-4) largest = std::max(largest, (f + radius * v / v.norm()).norm() * std::min(1.0, v.norm()));
    if (f.norm() < radius * (1 - 1e-6) - 1e-5) largest = std::max(largest, v.norm());
  }
  return largest;
}

TEST(ContactForces, ConvexProblemsAreSolvedToTheProof) {
  Random random(1);
  for (int run = 0; run < 10000; ++run) {
    ContactProblem qp = convexProblem(random, run);
    solveForces(qp, nullptr, kWork);
    ASSERT_TRUE(qp.converged) << run;
    ASSERT_LT(distanceFromRight(qp), 2e-4) << run;  // the root of what rows lack, 1e-8 at most
  }
}

// By itself, from forces far away: what Newton's method leaves open is settled by it.
TEST(ContactForces, TheProximalPointMethodConvergesFromAnyStart) {
  Random random(7);
  for (int run = 0; run < 1000; ++run) {
    ContactProblem qp = convexProblem(random, run);
    qp.tolerance = 1e-6;
    for (ContactRow& row : qp.rows) row.multiplier = random.between(0, 5);
    ContactSystem system(qp, nullptr);
    system.most = 1e12;
    approachMinimum(system);
    ASSERT_LE(system.residual(), qp.tolerance) << run;
  }
}

TEST(ContactForces, AgreesWithASlowSolver) {
  Random random(3);
  for (int run = 0; run < 10000; ++run) {
    ContactProblem qp = convexProblem(random, run);
    solveForces(qp, nullptr, kWork);
    ASSERT_LT((qp.y - SlowSolver(qp).answer(100000)).norm(), 1e-6) << run;
  }
}

TEST(ContactForces, AcceptsTheSolutionAsAGuess) {
  Random random(2);
  for (int run = 0; run < 1000; ++run) {
    ContactProblem qp = convexProblem(random, run);
    solveForces(qp, nullptr, kWork);
    const Vector6 y = qp.y;
    solveForces(qp, nullptr, kWork);
    ASSERT_LE(qp.iterations, 3) << run;
    ASSERT_LT((qp.y - y).norm(), 1e-7);
    // The answer does not depend on the order of rows and discs.
    ContactProblem other = qp;
    std::reverse(other.rows.begin(), other.rows.begin() + other.row_count);
    std::reverse(other.discs.begin(), other.discs.begin() + other.disc_count);
    for (int k = 0; k < other.row_count; ++k) other.rows[static_cast<std::size_t>(k)].multiplier = random.between(0, 3);
    for (int k = 0; k < other.disc_count; ++k) {
      FrictionDisc& disc = other.discs[static_cast<std::size_t>(k)];
      disc.force = {};
      disc.row = other.row_count - 1 - disc.row;
    }
    solveForces(other, nullptr, kWork);
    ASSERT_LT((other.y - y).norm(), 1e-7) << run;
  }
}

TEST(ContactForces, StickingIsExact) {
  // A block that is pulled by less than friction holds does not move at all; if pulled by more, it slides by the
  // difference.
  for (const double pull : {0.1, 0.199, 0.201, 1.0}) {
    ContactProblem qp;
    qp.target << pull, 0, -1, 0, 0, 0;
    qp.row_count = qp.disc_count = 1;
    qp.rows[0].a << 0, 0, 1, 0, 0, 0;
    qp.discs[0].across[0] << 1, 0, 0, 0, 0, 0;
    qp.discs[0].across[1] << 0, 1, 0, 0, 0, 0;
    qp.discs[0].radius = 0.2;
    solveForces(qp, nullptr, kWork);
    EXPECT_NEAR(qp.y[0], std::max(0.0, pull - 0.2), 1e-8) << pull;
    EXPECT_NEAR(qp.rows[0].multiplier, 1, 1e-8);
    EXPECT_NEAR(qp.discs[0].force[0], -std::min(pull, 0.2), 1e-8);
  }
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
    solveForces(p->qp, &p->compliance, kWork);
    for (int d = 0; d < p->qp.disc_count; ++d) {
      const FrictionDisc& disc = p->qp.discs[static_cast<std::size_t>(d)];
      ASSERT_LE(std::hypot(disc.force[0], disc.force[1]),
                disc.friction * p->qp.rows[static_cast<std::size_t>(disc.row)].multiplier * (1 + 1e-9) + 1e-12)
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
INSTANTIATE_TEST_SUITE_P(FewAndAll, ContactForcesLaw, testing::Values(LawCase{10, 0.999, 7}, LawCase{kMaxContactRows, 0.97, 17}));

TEST(ContactForces, TheAnswerAsAGuessIsFoundAtOnce) {
  Random random(3);
  for (int run = 0; run < 500; ++run) {
    const auto p = randomProblem(random, 1 + run % 8, 12, true);
    solveForces(p->qp, &p->compliance, kWork);
    if (!p->qp.converged) continue;
    const Vector6 y = p->qp.y;
    solveForces(p->qp, &p->compliance, kWork);
    ASSERT_LE(p->qp.iterations, 2) << run;
    ASSERT_LT((p->qp.y - y).norm(), 1e-5);
  }
}

// The last thing that is begun is at most a Newton step for all forces.
TEST(ContactForces, WorkIsBounded) {
  Random random(6);
  std::uint32_t largest = 0;
  for (int run = 0; run < 300; ++run) {
    const auto p = randomProblem(random, 1 + run % kMaxContactRows, 12, true);
    constexpr std::uint32_t kLittle = 1000, kStep = 25'000;
    const std::uint32_t work = solveForces(p->qp, &p->compliance, kLittle);
    ASSERT_LE(work, kLittle + kStep);
    largest = std::max(largest, work);
    for (int d = 0; d < p->qp.disc_count; ++d) {
      const FrictionDisc& disc = p->qp.discs[static_cast<std::size_t>(d)];
      ASSERT_LE(std::hypot(disc.force[0], disc.force[1]),
                disc.friction * p->qp.rows[static_cast<std::size_t>(disc.row)].multiplier * (1 + 1e-9) + 1e-12);
    }
  }
  EXPECT_GT(largest, 1000u) << "some of them would take more";
}

TEST(ContactForces, AGroupAndTheToolAreSpringsInSeries) {
  ContactProblem qp;
  qp.target << 0, 0, -1, 0, 0, 0;
  qp.rows[0].a << 0, 0, 1, 0, 0, 0;
  qp.rows[0].group = 0;
  qp.rows[0].give = std::sqrt(3);
  qp.rows[2] = qp.rows[1] = qp.rows[0];
  qp.row_count = 3;
  qp.group_count = 1;
  solveForces(qp, nullptr, kWork);
  EXPECT_NEAR(qp.y[2], -0.75, 1e-8);
  EXPECT_NEAR(qp.rows[0].multiplier + qp.rows[1].multiplier + qp.rows[2].multiplier, 0.25, 1e-8);
}

TEST(ContactForces, WithoutDiscsRowsAndTissueAreSpringsInSeries) {
  ForceProblem p{};
  p.qp.target << 0, 0, -1, 0, 0, 0;
  p.qp.row_count = 1;
  p.qp.rows[0].a << 0, 0, 1, 0, 0, 0;
  p.compliance[0][0] = 3;
  solveForces(p.qp, &p.compliance, kWork);
  EXPECT_TRUE(p.qp.converged);
  EXPECT_NEAR(p.qp.rows[0].multiplier, 0.25, 1e-8);
  EXPECT_NEAR(p.qp.y[2], -0.75, 1e-8);
}

}  // namespace
}  // namespace spheretree::runtime
