// SPDX-License-Identifier: Apache-2.0
#include "contact/qp6.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Dense>

#include "kernel/kernel.h"
#include "support/random.h"

namespace spheretree::runtime {
namespace {

using test::Random;
using Vec = Eigen::Matrix<double, 6, 1>;

struct Problem {
  std::vector<float> memory;
  QpRows rows;
  Vector6 target = Vector6::Zero();

  Problem(const std::vector<Vec>& normals, const std::vector<double>& bounds) {
    const std::size_t stride = (normals.size() + 15) / 8 * 8;
    memory.assign(7 * stride, 0);
    for (std::size_t i = 0; i < stride; ++i) memory[6 * stride + i] = -1e30f;
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const double length = normals[i].norm();
      for (std::size_t k = 0; k < 6; ++k) memory[k * stride + i] = static_cast<float>(normals[i][static_cast<int>(k)] / length);
      memory[6 * stride + i] = static_cast<float>(bounds[i] / length);
    }
    for (std::size_t k = 0; k < 6; ++k) rows.a[k] = memory.data() + k * stride;
    rows.b = memory.data() + 6 * stride;
    rows.count = static_cast<std::uint32_t>(normals.size());
  }
  Problem(const Problem&) = delete;
  Problem& operator=(const Problem&) = delete;
  Vec normal(std::uint32_t i) const {
    Vec n;
    for (std::size_t k = 0; k < 6; ++k) n[static_cast<int>(k)] = static_cast<double>(rows.a[k][i]);
    return n;
  }
  double slack(std::uint32_t i, const Vec& y) const { return normal(i).dot(y) - static_cast<double>(rows.b[i]); }
};

QpAnswer solve(const Problem& p, const QpAnswer& warm = {}) {
  QpAnswer answer = warm;
  solveQp6(scalarKernel(), p.rows, p.target, answer);
  return answer;
}

double tolerance(const QpAnswer& a) { return 2 * (kQpTolerance + 1e-6 * a.y.cwiseAbs().maxCoeff()); }

// Proves optimality or infeasibility from the rows alone.
void certify(const Problem& p, const QpAnswer& answer) {
  if (answer.status == QpStatus::Infeasible) {
    ASSERT_GT(answer.certificate_count, 0);
    Vec sum = Vec::Zero();
    double bound = 0, weight = 0;
    for (std::size_t k = 0; k < answer.certificate_count; ++k) {
      ASSERT_GT(answer.certificate_weight[k], 0);
      sum += answer.certificate_weight[k] * p.normal(answer.certificate[k]);
      bound += answer.certificate_weight[k] * static_cast<double>(p.rows.b[answer.certificate[k]]);
      weight += answer.certificate_weight[k];
    }
    // A feasible y would need |y| >= bound / |sum|, which is far away.
    EXPECT_GT(bound, 0);
    EXPECT_LT(sum.norm(), 1e-4 * weight);
    EXPECT_GT(bound / std::max(sum.norm(), 1e-300), 0.5);
    return;
  }
  ASSERT_EQ(answer.status, QpStatus::Optimal);
  const Vec y = answer.y;
  for (std::uint32_t i = 0; i < p.rows.count; ++i) ASSERT_GE(p.slack(i, y), -tolerance(answer)) << "row " << i;
  Vec gradient = y - Vec(p.target);
  for (std::size_t k = 0; k < answer.active_count; ++k) {
    EXPECT_GE(answer.multiplier[k], -1e-9);
    EXPECT_NEAR(p.slack(answer.active[k], y), 0, 1e-8 * (1 + y.norm()));
    gradient -= answer.multiplier[k] * p.normal(answer.active[k]);
  }
  EXPECT_LT(gradient.norm(), 1e-8 * (1 + (y - Vec(p.target)).norm()));
}

// The oracle: tries every set of up to 6 rows as the active one, with a general least-squares solver; empty if none
// fits.
std::optional<Vec> byEnumeration(const Problem& p) {
  const std::uint32_t n = p.rows.count;
  for (std::uint32_t mask = 0; mask < 1u << n; ++mask) {
    if (__builtin_popcount(mask) > 6) continue;
    Eigen::MatrixXd a(__builtin_popcount(mask), 6);
    Eigen::VectorXd b(a.rows());
    int row = 0;
    for (std::uint32_t i = 0; i < n; ++i)
      if (mask >> i & 1) {
        a.row(row) = p.normal(i).transpose();
        b[row++] = static_cast<double>(p.rows.b[i]);
      }
    Vec y = p.target;
    if (row > 0) {
      const Eigen::MatrixXd gram = a * a.transpose();
      const Eigen::FullPivLU<Eigen::MatrixXd> lu(gram);
      if (lu.rank() < row) continue;
      const Eigen::VectorXd u = lu.solve(b - a * Vec(p.target));
      if (u.minCoeff() < -1e-9) continue;
      y += a.transpose() * u;
    }
    bool feasible = true;
    for (std::uint32_t i = 0; i < n; ++i) feasible &= p.slack(i, y) >= -1e-8;
    if (feasible) return y;
  }
  return {};
}

Vec randomVec(Random& random, double half = 1) {
  Vec v;
  for (int k = 0; k < 6; ++k) v[k] = random.between(-half, half);
  return v;
}

TEST(Qp6, AgreesWithAnEnumerationOfAllActiveSets) {
  int infeasible = 0, bound = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Random random(seed);
    std::vector<Vec> normals;
    std::vector<double> bounds;
    const std::uint64_t n = 1 + random.below(11);
    for (std::uint64_t i = 0; i < n; ++i) {
      normals.push_back(i > 2 && random.below(4) == 0 ? Vec(-normals[random.below(i)]) : randomVec(random));
      bounds.push_back(random.between(-1.5, 0.7));
    }
    Problem p(normals, bounds);
    p.target = randomVec(random, 5);
    const QpAnswer answer = solve(p);
    certify(p, answer);
    const std::optional<Vec> oracle = byEnumeration(p);
    ASSERT_EQ(oracle.has_value(), answer.status == QpStatus::Optimal) << "seed " << seed;
    if (oracle) {
      EXPECT_LT((*oracle - Vec(answer.y)).norm(), 1e-4) << "seed " << seed;
    }
    infeasible += !oracle;
    bound += oracle && answer.active_count > 1;
  }
  EXPECT_GT(infeasible, 20);
  EXPECT_GT(bound, 100);
}

// Rows like those of a tool: unit force directions with lever arms, gaps from a feasible pose.
void contactRows(Random& random, std::size_t n, double min_gap, std::vector<Vec>& normals, std::vector<double>& bounds) {
  for (std::size_t i = 0; i < n; ++i) {
    Eigen::Vector3d normal(random.between(-1, 1), random.between(-0.3, 0.3), random.between(0.2, 1));
    normal.normalize();
    const Eigen::Vector3d arm(random.between(-5, 5), random.between(-5, 5), random.between(-60, 60));
    Vec row;
    row << normal, arm.cross(normal) / 31.6;
    normals.push_back(row);
    bounds.push_back(-random.between(min_gap, 1));
  }
}

TEST(Qp6, ManyRowsCertifiedColdAndWarm) {
  long cold_iterations = 0, warm_iterations = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    std::vector<Vec> normals;
    std::vector<double> bounds;
    contactRows(random, 20 + random.below(2000), 0, normals, bounds);
    Problem p(normals, bounds);
    p.target = randomVec(random, 20);
    const QpAnswer cold = solve(p);
    certify(p, cold);
    p.target += Vector6(randomVec(random, 0.05));
    const QpAnswer warm = solve(p, cold), fresh = solve(p);
    certify(p, warm);
    EXPECT_LT((Vec(warm.y) - Vec(fresh.y)).norm(), 1e-3);
    cold_iterations += fresh.iterations;
    warm_iterations += warm.iterations;
  }
  EXPECT_LT(2 * warm_iterations, cold_iterations);
}

TEST(Qp6, DependentRowsDoNotMakeItCycle) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    Random random(seed);
    std::vector<Vec> normals;
    std::vector<double> bounds;
    contactRows(random, 100, 0, normals, bounds);
    for (std::size_t i = 0; i < 100; ++i)
      for (const double noise : {0.0, 1e-8, 1e-5}) {
        normals.push_back(normals[i] + randomVec(random, noise));
        bounds.push_back(bounds[i]);
      }
    Problem p(normals, bounds);
    p.target = randomVec(random, 20);
    const QpAnswer answer = solve(p);
    ASSERT_EQ(answer.status, QpStatus::Optimal);
    for (std::uint32_t i = 0; i < p.rows.count; ++i) ASSERT_GE(p.slack(i, answer.y), -tolerance(answer));
    EXPECT_LE(answer.iterations, 60);
  }
}

TEST(Qp6, KnownAnswers) {
  const Vec x = Vec::Unit(0), z = Vec::Unit(2);
  {
    Problem p({z}, {0.5});  // a floor at z = 0.5
    p.target[0] = 3;
    p.target[2] = -2;
    const QpAnswer a = solve(p);
    EXPECT_EQ(a.status, QpStatus::Optimal);
    EXPECT_DOUBLE_EQ(a.y[0], 3);
    EXPECT_DOUBLE_EQ(a.y[2], 0.5);
    ASSERT_EQ(a.active_count, 1);
    EXPECT_DOUBLE_EQ(a.multiplier[0], 2.5);
  }
  {
    Problem p({x, -x}, {0, 1});  // x >= 0 and x <= -1
    const QpAnswer a = solve(p);
    EXPECT_EQ(a.status, QpStatus::Infeasible);
    EXPECT_EQ(a.certificate_count, 2);
    certify(p, a);
  }
  {
    Problem p({}, {});
    p.target[4] = 7;
    const QpAnswer a = solve(p);
    EXPECT_EQ(a.status, QpStatus::Optimal);
    EXPECT_EQ(a.y, p.target);
  }
}

TEST(Qp6, AnyWarmStartIsFine) {
  Random random(5);
  std::vector<Vec> normals;
  std::vector<double> bounds;
  contactRows(random, 300, 0, normals, bounds);
  Problem p(normals, bounds);
  p.target = randomVec(random, 10);
  const QpAnswer cold = solve(p);
  for (int n = 0; n < 200; ++n) {
    QpAnswer warm;
    warm.active_count = static_cast<std::uint8_t>(random.below(7));
    for (auto& row : warm.active) row = static_cast<std::uint32_t>(random.below(400));
    const QpAnswer answer = solve(p, warm);
    certify(p, answer);
    EXPECT_LT((Vec(answer.y) - Vec(cold.y)).norm(), 1e-3);
  }
}

TEST(Qp6, KernelsGiveTheSameBits) {
  if (!avx2Kernel()) GTEST_SKIP() << "no AVX2 here";
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    Random random(seed);
    std::vector<Vec> normals;
    std::vector<double> bounds;
    contactRows(random, 1 + random.below(500), -0.01, normals, bounds);
    Problem p(normals, bounds);
    p.target = randomVec(random, 10);
    QpAnswer a, b;
    solveQp6(scalarKernel(), p.rows, p.target, a);
    solveQp6(*avx2Kernel(), p.rows, p.target, b);
    EXPECT_EQ(a.y, b.y);
    EXPECT_EQ(a.active, b.active);
  }
}

}  // namespace
}  // namespace spheretree::runtime
