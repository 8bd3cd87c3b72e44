// SPDX-License-Identifier: GPL-3.0-or-later
// The QP of the haptic step against an independent solver with exact numbers: CGAL's, after K. Fischer, B. Gaertner, S.
// Schoenherr, F. Wessendorp. Separate from the tests of the runtime, which stay free of the GPL.
#include <CGAL/Gmpzf.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "contact/qp6.h"
#include "kernel/kernel.h"
#include "support/random.h"

namespace spheretree::runtime {
namespace {

struct Row {
  std::array<float, 6> normal;
  float bound;
};

// Rows of unit length. With `side`, they point towards one side and leave space; rows of every direction often do not.
std::vector<Row> randomRows(test::Random& random, std::size_t count, double side) {
  std::vector<Row> rows(count);
  for (Row& row : rows) {
    std::array<double, 6> normal{};
    double square = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      normal[k] = random.between(-1, 1) + (k == 2 ? side : 0);
      square += normal[k] * normal[k];
    }
    for (std::size_t k = 0; k < 6; ++k) row.normal[k] = static_cast<float>(normal[k] / std::sqrt(square));
    row.bound = static_cast<float>(random.between(-1, 0.3) / std::sqrt(square));
  }
  return rows;
}

QpAnswer ours(const std::vector<Row>& rows, const std::array<double, 6>& target) {
  const std::size_t stride = (rows.size() + 15) / 8 * 8;
  std::vector<float> memory(7 * stride, 0.0f);
  for (std::size_t i = 0; i < stride; ++i) {
    memory[6 * stride + i] = i < rows.size() ? rows[i].bound : -1e30f;
    for (std::size_t k = 0; k < 6 && i < rows.size(); ++k) memory[k * stride + i] = rows[i].normal[k];
  }
  QpRows view;
  for (std::size_t k = 0; k < 6; ++k) view.a[k] = memory.data() + k * stride;
  view.b = memory.data() + 6 * stride;
  view.count = static_cast<std::uint32_t>(rows.size());
  Vector6 wanted;
  for (int k = 0; k < 6; ++k) wanted[k] = target[static_cast<std::size_t>(k)];
  QpAnswer answer;
  solveQp6(scalarKernel(), view, wanted, answer);
  return answer;
}

/// Exact minimum of |y - target|^2 / 2, rounded once to double; false if no y satisfies the rows.
bool exact(const std::vector<Row>& rows, const std::array<double, 6>& target, std::array<double, 6>& y) {
  CGAL::Quadratic_program<double> program(CGAL::LARGER, false, 0, false, 0);
  for (int k = 0; k < 6; ++k) {
    program.set_d(k, k, 1);
    program.set_c(k, -target[static_cast<std::size_t>(k)]);
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (std::size_t k = 0; k < 6; ++k) program.set_a(static_cast<int>(k), static_cast<int>(i), static_cast<double>(rows[i].normal[k]));
    program.set_b(static_cast<int>(i), static_cast<double>(rows[i].bound));
  }
  const auto solution = CGAL::solve_quadratic_program(program, CGAL::Gmpzf());
  if (!solution.is_optimal()) return false;
  auto value = solution.variable_values_begin();
  for (double& coordinate : y) coordinate = CGAL::to_double(*value++);
  return true;
}

TEST(Qp6, AgreesWithAnExactSolver) {
  test::Random random(77);
  int optimal = 0, infeasible = 0;
  for (int n = 0; n < 1200; ++n) {
    const std::vector<Row> rows = randomRows(random, 1 + random.below(n % 3 ? 40 : 200), n % 4 ? 1 : 0);
    std::array<double, 6> target{}, y{};
    for (double& coordinate : target) coordinate = random.between(-2, 2);
    const QpAnswer answer = ours(rows, target);
    ASSERT_NE(answer.status, QpStatus::IterationLimit) << n;
    const bool solved = exact(rows, target, y);
    double size = 0, distance = 0, weights = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      size = std::max(size, std::abs(y[k]));
      distance += (y[k] - answer.y[static_cast<int>(k)]) * (y[k] - answer.y[static_cast<int>(k)]);
    }
    if (answer.status == QpStatus::Infeasible) {  // within the tolerance of a row both answers may be right, if the minimum is far away
      EXPECT_TRUE(!solved || size > 1e3) << n;
      ++infeasible;
      continue;
    }
    ASSERT_TRUE(solved) << n;
    ++optimal;
    // A row may be violated by the tolerance: the objective then differs by the tolerance times the multipliers, and
    // the point by the square root of that.
    for (std::size_t k = 0; k < answer.active_count; ++k) weights += answer.multiplier[k];
    const double tolerance = 2 * (kQpTolerance + 1e-6 * size);
    EXPECT_LT(std::sqrt(distance), std::sqrt(2 * tolerance * weights) + 1e-9) << n;
  }
  EXPECT_GT(optimal, 500);
  EXPECT_GT(infeasible, 100);
}

}  // namespace
}  // namespace spheretree::runtime
