// SPDX-License-Identifier: Apache-2.0
#include "contact/contact_qp.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "support/random.h"

namespace spheretree::runtime {
namespace {

using test::Random;

Vector6 randomVector(Random& random, double half) {
  Vector6 v;
  for (int k = 0; k < 6; ++k) v[k] = random.between(-half, half);
  return v;
}

// Rows that all allow `free`, some of them soft, in groups and alone. Every tenth problem has dependent rows.
ContactQp randomProblem(Random& random, int run) {
  ContactQp qp;
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
    if (k % 4 == 1) row.compliance = random.between(0.01, 2);
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
    if (run % 2 == 0 || k >= qp.row_count) continue;
    disc.friction = random.between(0.05, 2);  // a cone that contains `free`
    disc.row = k;
    const double slip = std::hypot(disc.across[0].dot(free) - disc.origin[0], disc.across[1].dot(free) - disc.origin[1]);
    disc.slip = slip + (k % 3 == 0 ? random.between(0, 0.5) : 0);
  }
  return qp;
}

double givenPart(const ContactQp& qp, int k) {
  const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
  return row.group < 0 ? 0 : row.give * qp.given[static_cast<std::size_t>(row.group)];
}

double lacks(const ContactQp& qp, int k) {
  const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
  return row.b - row.a.dot(qp.y) - givenPart(qp, k);
}

// A bound on the distance of an answer from the solution: the gap between a value that the answer reaches and one that
// no feasible point can undercut, by forces that the laws of friction and contact allow (weak duality); the problem is
// strongly convex. The bound holds for any method.
double distanceFromRight(const ContactQp& qp) {
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
    if (row.compliance > 0)
      primal += std::max(0.0, lack) * std::max(0.0, lack) / (2 * row.compliance);
    else
      EXPECT_LT(lack, 1e-7);
    press(k, u);
    dual += u * row.b - 0.5 * row.compliance * u * u;
  }
  for (int k = 0; k < qp.disc_count; ++k) {
    const FrictionDisc& disc = qp.discs[static_cast<std::size_t>(k)];
    const double slip = std::hypot(disc.across[0].dot(qp.y) - disc.origin[0], disc.across[1].dot(qp.y) - disc.origin[1]);
    const double radius = disc.friction > 0 ? disc.friction * disc.pressure : disc.radius;
    EXPECT_LE(std::hypot(disc.force[0], disc.force[1]), radius * (1 + 1e-9) + 1e-12);
    if (disc.friction > 0) {
      EXPECT_LT(lacks(qp, disc.row) + disc.friction * (slip - disc.slip), 1e-7);
      press(disc.row, disc.pressure);
      dual += disc.pressure * (qp.rows[static_cast<std::size_t>(disc.row)].b - disc.friction * disc.slip);
    } else {
      primal += disc.radius * slip;
    }
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

TEST(ContactQp, RandomProblemsAreSolvedToTheProof) {
  Random random(1);
  int largest = 0;
  double total = 0;
  for (int run = 0; run < 10000; ++run) {
    ContactQp qp = randomProblem(random, run);
    solveContactQp(qp);
    ASSERT_TRUE(qp.converged) << run;
    largest = std::max(largest, qp.iterations);
    total += qp.iterations;
    // The proof bounds the error of the value, and the distance is its square root: rows that lack 1e-8 give 1e-4.
    const Vector6 first = qp.y;
    for (int n = 0; n < 8; ++n) solveContactQp(qp);
    ASSERT_LT((qp.y - first).norm(), 1e-6) << run;
    ASSERT_LT(distanceFromRight(qp), 1e-4) << run;
  }
  EXPECT_LT(total / 10000, 15);
  EXPECT_LT(largest, 150);
}

// A slow independent solver: each multiplier or force in turn is optimised with the others fixed; for a cone, by a
// gradient step and projection onto the cone.
class SlowSolver {
 public:
  explicit SlowSolver(const ContactQp& qp) : qp_(qp), y_(qp.target), given_(qp.rest) {}
  Vector6 answer(int sweeps) {
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      double change = 0;
      for (int k = 0; k < qp_.row_count; ++k) {
        const auto at = static_cast<std::size_t>(k);
        const ContactRow& row = qp_.rows[at];
        const double by = std::max(-u_[at], (lack(k) - row.compliance * u_[at]) / (size(k) + row.compliance));
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
    const double mu = disc.friction;
    double all = disc.across[0].squaredNorm() + disc.across[1].squaredNorm();
    if (mu > 0) all += size(disc.row);
    std::array<double, 2> next = force_[at];
    for (std::size_t i = 0; i < 2; ++i) next[i] -= (disc.across[i].dot(y_) - disc.origin[i]) / all;
    const double length = std::hypot(next[0], next[1]);
    double shrink = length > disc.radius ? disc.radius / length : 1, change = 0;
    if (mu > 0) {
      const double wish = pressure_[at] + (lack(disc.row) - mu * disc.slip) / all;
      const double u = length <= mu * wish ? wish : std::max(0.0, (wish + mu * length) / (1 + mu * mu));
      shrink = length <= mu * wish ? 1 : mu * u / length;
      change = std::abs(u - pressure_[at]);
      press(disc.row, u - pressure_[at]);
      pressure_[at] = u;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      const double by = shrink * next[i] - force_[at][i];
      force_[at][i] += by;
      y_ += by * disc.across[i];
      change = std::max(change, std::abs(by));
    }
    return change;
  }

  const ContactQp& qp_;
  Vector6 y_;
  std::array<double, kMaxGroups> given_;
  std::array<double, kMaxContactRows> u_{}, pressure_{};
  std::array<std::array<double, 2>, kMaxContactRows> force_{};
};

TEST(ContactQp, AgreesWithASlowSolver) {
  Random random(3);
  for (int run = 0; run < 10000; ++run) {
    ContactQp qp = randomProblem(random, run);
    solveContactQp(qp);
    ASSERT_LT((qp.y - SlowSolver(qp).answer(100000)).norm(), 1e-6) << run;
  }
}

TEST(ContactQp, AcceptsTheSolutionAsAGuess) {
  Random random(2);
  for (int run = 0; run < 1000; ++run) {
    ContactQp qp = randomProblem(random, run);
    solveContactQp(qp);
    const Vector6 y = qp.y;
    solveContactQp(qp);
    ASSERT_LE(qp.iterations, 3) << run;
    ASSERT_LT((qp.y - y).norm(), 1e-7);
    // The answer does not depend on the order of rows and discs.
    ContactQp other = qp;
    std::reverse(other.rows.begin(), other.rows.begin() + other.row_count);
    std::reverse(other.discs.begin(), other.discs.begin() + other.disc_count);
    for (int k = 0; k < other.row_count; ++k) other.rows[static_cast<std::size_t>(k)].multiplier = random.between(0, 3);
    for (int k = 0; k < other.disc_count; ++k) {
      FrictionDisc& disc = other.discs[static_cast<std::size_t>(k)];
      disc.force = {};
      disc.pressure = 0;
      disc.row = other.row_count - 1 - disc.row;
    }
    other.y.setZero();
    solveContactQp(other);
    ASSERT_LT((other.y - y).norm(), 1e-7) << run;
  }
}

TEST(ContactQp, StickingIsExact) {
  // A block that is pulled by less than friction holds does not move at all; if pulled by more, it slides by the
  // difference.
  for (const double pull : {0.1, 0.199, 0.201, 1.0}) {
    ContactQp qp;
    qp.target << pull, 0, -1, 0, 0, 0;
    qp.row_count = qp.disc_count = 1;
    qp.rows[0].a << 0, 0, 1, 0, 0, 0;
    qp.discs[0].across[0] << 1, 0, 0, 0, 0, 0;
    qp.discs[0].across[1] << 0, 1, 0, 0, 0, 0;
    qp.discs[0].radius = 0.2;
    solveContactQp(qp);
    EXPECT_NEAR(qp.y[0], std::max(0.0, pull - 0.2), 1e-9) << pull;
    EXPECT_NEAR(qp.rows[0].multiplier, 1, 1e-9);
    EXPECT_NEAR(qp.discs[0].force[0], -std::min(pull, 0.2), 1e-8);
  }
}

// Contacts of a random tool, pressed and dragged: where the exact law is requested and found, the forces obey it, and a
// problem of cones with the slip of the answer, which the same forces solve, has the same answer.
TEST(ContactQp, CoulombsLawIsThatOfConesWithTheSlipOfTheAnswer) {
  Random random(5);
  int found = 0, slipping = 0, sticking = 0;
  for (int run = 0; run < 2000; ++run) {
    ContactQp qp;
    qp.row_count = qp.disc_count = 1 + run % 3;
    Vector6 press = Vector6::Zero();
    for (int k = 0; k < qp.row_count; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const Eigen::Vector3d n = (Eigen::Vector3d(0, 0, 1) + 0.5 * random.inCube(1)).normalized(), arm = random.inCube(1),
                            t0 = n.unitOrthogonal(), t1 = n.cross(t0);
      qp.rows[at].a << n, arm.cross(n);
      press += qp.rows[at].a;
      qp.rows[at].multiplier = 1;
      qp.discs[at].across[0] << t0, arm.cross(t0);
      qp.discs[at].across[1] << t1, arm.cross(t1);
      qp.discs[at].law = random.between(0.05, 0.8);
      qp.discs[at].row = k;
    }
    qp.target = 0.5 * randomVector(random, 1) - press;
    solveContactQp(qp);
    if (!qp.converged) continue;
    ++found;
    ContactQp cones = qp;
    for (int k = 0; k < qp.disc_count; ++k) {
      const auto at = static_cast<std::size_t>(k);
      FrictionDisc &disc = qp.discs[at], &cone = cones.discs[at];
      const double slip = std::hypot(disc.across[0].dot(qp.y), disc.across[1].dot(qp.y)), force = std::hypot(disc.force[0], disc.force[1]),
                   allowed = disc.law * qp.rows[at].multiplier;
      ASSERT_LE(force, allowed * (1 + 1e-9));
      if (slip > 1e-5) {
        ASSERT_NEAR(force, allowed, 1e-9 * (1 + allowed));
        ++slipping;
      } else {
        ++sticking;
      }
      cone.friction = disc.law;
      cone.law = 0;
      cone.slip = slip;
      cones.rows[at].multiplier = 0;  // the cone presses instead of it
    }
    for (int n = 0; n < 4; ++n) solveContactQp(cones);  // an answer is off by the root of what its value is off
    ASSERT_TRUE(cones.converged);
    ASSERT_LT((cones.y - qp.y).norm(), 1e-6) << run;
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(slipping, 300);
  EXPECT_GT(sticking, 500);
}

TEST(ContactQp, SpringsInSeries) {
  // One soft row alone, and one group of three soft rows: both act like a spring behind the tool's spring.
  ContactQp qp;
  qp.target << 0, 0, -1, 0, 0, 0;
  qp.row_count = 1;
  qp.rows[0].a << 0, 0, 1, 0, 0, 0;
  qp.rows[0].compliance = 3;
  solveContactQp(qp);
  EXPECT_NEAR(qp.rows[0].multiplier, 0.25, 1e-9);
  qp.rows[0].compliance = 0;
  qp.rows[0].group = 0;
  qp.rows[0].give = std::sqrt(3);
  qp.rows[2] = qp.rows[1] = qp.rows[0];
  qp.row_count = 3;
  qp.group_count = 1;
  solveContactQp(qp);
  EXPECT_NEAR(qp.y[2], -0.75, 1e-9);
  EXPECT_NEAR(qp.rows[0].multiplier + qp.rows[1].multiplier + qp.rows[2].multiplier, 0.25, 1e-8);
}

}  // namespace
}  // namespace spheretree::runtime
