// SPDX-License-Identifier: Apache-2.0
#include "contact_qp.h"

#include <gtest/gtest.h>

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

// Rows that all allow `free`; soft ones, in groups and alone, among them. Every tenth problem has dependent rows.
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
  qp.tissue_count = run % 5 == 1 ? 4 : 0;
  Random own(static_cast<std::uint64_t>(run));
  for (int k = 0; k < qp.row_count; ++k)
    for (int m = 0; m < qp.tissue_count; ++m)  // the first rows give way under each other's forces
      qp.tissue[static_cast<std::size_t>(k)][static_cast<std::size_t>(m)] = k < 4 && m <= k ? own.between(-1, 1) : 0;
  qp.disc_count = static_cast<int>(random.between(0, 6));
  for (int k = 0; k < qp.disc_count; ++k) {
    FrictionDisc& disc = qp.discs[static_cast<std::size_t>(k)];
    for (Vector6& t : disc.across) t = randomVector(random, 1);
    disc.radius = random.between(0, 1) * random.between(0, 1.5);
    if (run % 4 == 0) disc.origin = {random.between(-0.1, 0.1), random.between(-0.1, 0.1)};
  }
  return qp;
}

double givenPart(const ContactQp& qp, int k) {
  const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
  double part = row.group < 0 ? 0 : row.give * qp.given[static_cast<std::size_t>(row.group)];
  for (std::size_t m = 0; m < static_cast<std::size_t>(qp.tissue_count); ++m)
    part += qp.tissue[static_cast<std::size_t>(k)][m] * qp.tissue_given[m];
  return part;
}

// No answer is farther from the right one than this: the gap between a value that the answer reaches and one that
// nothing can get below, by forces that the laws of friction and contact allow (weak duality); the problem is strongly
// convex. A bound on its own, whatever the method.
double distanceFromRight(const ContactQp& qp) {
  double primal = 0.5 * (qp.y - qp.target).squaredNorm(), dual = 0;
  Vector6 pull = Vector6::Zero();
  std::array<double, kMostGroups> group_pull{};
  std::array<double, kMostContactRows> tissue_pull{};
  for (std::size_t m = 0; m < static_cast<std::size_t>(qp.tissue_count); ++m) primal += 0.5 * qp.tissue_given[m] * qp.tissue_given[m];
  for (int g = 0; g < qp.group_count; ++g) {
    const auto at = static_cast<std::size_t>(g);
    primal += 0.5 * (qp.given[at] - qp.rest[at]) * (qp.given[at] - qp.rest[at]);
  }
  for (int k = 0; k < qp.row_count; ++k) {
    const ContactRow& row = qp.rows[static_cast<std::size_t>(k)];
    const double u = row.multiplier;
    EXPECT_GE(u, 0);
    const double lacks = row.b - row.a.dot(qp.y) - givenPart(qp, k);
    if (row.compliance > 0)
      primal += std::max(0.0, lacks) * std::max(0.0, lacks) / (2 * row.compliance);
    else
      EXPECT_LT(lacks, 1e-7);
    pull += u * row.a;
    if (row.group >= 0) group_pull[static_cast<std::size_t>(row.group)] += u * row.give;
    for (std::size_t m = 0; m < static_cast<std::size_t>(qp.tissue_count); ++m)
      tissue_pull[m] += u * qp.tissue[static_cast<std::size_t>(k)][m];
    dual += u * row.b - 0.5 * row.compliance * u * u;
  }
  for (int k = 0; k < qp.disc_count; ++k) {
    const FrictionDisc& disc = qp.discs[static_cast<std::size_t>(k)];
    EXPECT_LE(std::hypot(disc.force[0], disc.force[1]), disc.radius * (1 + 1e-9) + 1e-12);
    primal += disc.radius * std::hypot(disc.across[0].dot(qp.y) - disc.origin[0], disc.across[1].dot(qp.y) - disc.origin[1]);
    for (std::size_t i = 0; i < 2; ++i) {
      pull += disc.force[i] * disc.across[i];
      dual += disc.force[i] * disc.origin[i];
    }
  }
  // The least of |y - t|^2 / 2 - pull . y over all y.
  dual += -0.5 * pull.squaredNorm() - pull.dot(qp.target);
  for (const double p : tissue_pull) dual -= 0.5 * p * p;
  for (int g = 0; g < qp.group_count; ++g) {
    const auto at = static_cast<std::size_t>(g);
    dual += -0.5 * group_pull[at] * group_pull[at] - group_pull[at] * qp.rest[at];
  }
  return std::sqrt(2 * std::max(0.0, primal - dual));
}

TEST(ContactQp, RandomProblemsAreSolvedToTheProof) {
  Random random(1);
  int most = 0;
  double total = 0;
  for (int run = 0; run < 10000; ++run) {
    ContactQp qp = randomProblem(random, run);
    solveContactQp(qp);
    ASSERT_TRUE(qp.converged) << run;
    most = std::max(most, qp.iterations);
    total += qp.iterations;
    // The proof says by how much the value may be off, and the distance is its root: rows that lack 1e-8 are 1e-4.
    const Vector6 first = qp.y;
    for (int n = 0; n < 8; ++n) solveContactQp(qp);
    ASSERT_LT((qp.y - first).norm(), 1e-6) << run;
    ASSERT_LT(distanceFromRight(qp), 1e-4) << run;
  }
  EXPECT_LT(total / 10000, 15);
  EXPECT_LT(most, 150);
}

// By force of patience: one multiplier or force after the other is made the best that it can be, the others as they
// are.
Vector6 patientAnswer(const ContactQp& qp, int sweeps) {
  Vector6 y = qp.target;
  std::array<double, kMostGroups> given = qp.rest;
  std::array<double, kMostContactRows> u{};
  std::array<double, kMostContactRows> tissue{};
  std::array<std::array<double, 2>, kMostContactRows> force{};
  const auto tissueDot = [&](std::size_t k, const auto& other) {
    double sum = 0;
    for (std::size_t m = 0; m < static_cast<std::size_t>(qp.tissue_count); ++m) sum += qp.tissue[k][m] * other[m];
    return sum;
  };
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    double change = 0;
    for (int k = 0; k < qp.row_count; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const ContactRow& row = qp.rows[at];
      const double g = row.group < 0 ? 0 : given[static_cast<std::size_t>(row.group)];
      const double lacks = row.b - row.a.dot(y) - row.give * g - tissueDot(at, tissue) - row.compliance * u[at];
      const double next = std::max(
                       0.0, u[at] + lacks / (row.a.squaredNorm() + row.give * row.give + tissueDot(at, qp.tissue[at]) + row.compliance)),
                   by = next - u[at];
      u[at] = next;
      y += by * row.a;
      if (row.group >= 0) given[static_cast<std::size_t>(row.group)] += by * row.give;
      for (std::size_t m = 0; m < static_cast<std::size_t>(qp.tissue_count); ++m) tissue[m] += by * qp.tissue[at][m];
      change = std::max(change, std::abs(by));
    }
    for (int k = 0; k < qp.disc_count; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const FrictionDisc& disc = qp.discs[at];
      const double size = disc.across[0].squaredNorm() + disc.across[1].squaredNorm();
      std::array<double, 2> next = force[at];
      for (std::size_t i = 0; i < 2; ++i) next[i] -= (disc.across[i].dot(y) - disc.origin[i]) / size;
      const double length = std::hypot(next[0], next[1]), shrink = length > disc.radius ? disc.radius / length : 1;
      for (std::size_t i = 0; i < 2; ++i) {
        const double by = shrink * next[i] - force[at][i];
        force[at][i] += by;
        y += by * disc.across[i];
        change = std::max(change, std::abs(by));
      }
    }
    if (change < 1e-14) break;
  }
  return y;
}

TEST(ContactQp, AgreesWithPatience) {
  Random random(3);
  for (int run = 0; run < 10000; ++run) {
    ContactQp qp = randomProblem(random, run);
    solveContactQp(qp);
    ASSERT_LT((qp.y - patientAnswer(qp, 100000)).norm(), 1e-6) << run;
  }
}

TEST(ContactQp, TheAnswerAsAGuessIsFound) {
  Random random(2);
  for (int run = 0; run < 1000; ++run) {
    ContactQp qp = randomProblem(random, run);
    solveContactQp(qp);
    const Vector6 y = qp.y;
    solveContactQp(qp);
    ASSERT_LE(qp.iterations, 3) << run;
    ASSERT_LT((qp.y - y).norm(), 1e-7);
    // Nor does it depend on the order of rows and discs.
    ContactQp other = qp;
    std::reverse(other.rows.begin(), other.rows.begin() + other.row_count);
    std::reverse(other.tissue.begin(), other.tissue.begin() + other.row_count);
    std::reverse(other.discs.begin(), other.discs.begin() + other.disc_count);
    for (int k = 0; k < other.row_count; ++k) other.rows[static_cast<std::size_t>(k)].multiplier = random.between(0, 3);
    for (int k = 0; k < other.disc_count; ++k) other.discs[static_cast<std::size_t>(k)].force = {};
    other.y.setZero();
    solveContactQp(other);
    ASSERT_LT((other.y - y).norm(), 1e-7) << run;
  }
}

TEST(ContactQp, StickingIsExact) {
  // A block that is pulled by less than friction holds does not move by the last bit that counts; by more, it slides by
  // the difference.
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

TEST(ContactQp, SpringsInSeries) {
  // One row that gives way by itself, and one group of three rows: both like a spring behind the tool's own.
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
