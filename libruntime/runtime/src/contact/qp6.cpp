// SPDX-License-Identifier: Apache-2.0
#include "contact/qp6.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernel/kernel.h"

namespace spheretree::runtime {
namespace {

constexpr double kDependent = 1e-10;  // squared length of the remainder of a unit row after projection on the active rows
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The active rows N (one in each column) as N = Q [R; 0], with Q orthogonal and R upper triangular: a row enters by a
// reflection and leaves by Givens rotations.
class ActiveSet {
 public:
  int size = 0;
  std::array<std::uint32_t, 6> row{};
  std::array<double, 6> bound{}, multiplier{};

  ActiveSet() {
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) q_[i][j] = i == j ? 1 : 0;
  }

  bool has(std::uint32_t r) const {
    for (int k = 0; k < size; ++k)
      if (row[k] == r) return true;
    return false;
  }

  // Components of `n` along the columns of Q: the first `size` in the span of the active rows, the others perpendicular
  // to it.
  void project(const Vector6& n, double d[6]) const {
    for (int j = 0; j < 6; ++j) {
      d[j] = 0;
      for (int i = 0; i < 6; ++i) d[j] += q_[j][i] * n[i];
    }
  }
  double squaredRest(const double d[6]) const {
    double sum = 0;
    for (int j = size; j < 6; ++j) sum += d[j] * d[j];
    return sum;
  }
  Vector6 rest(const double d[6]) const {
    Vector6 z = Vector6::Zero();
    for (int j = size; j < 6; ++j)
      for (int i = 0; i < 6; ++i) z[i] += d[j] * q_[j][i];
    return z;
  }
  // Solves R r = d for r.
  void solve(const double d[6], double r[6]) const {
    for (int i = size - 1; i >= 0; --i) {
      double sum = d[i];
      for (int j = i + 1; j < size; ++j) sum -= r_[i][j] * r[j];
      r[i] = sum / r_[i][i];
    }
  }

  // `d` = project(normal), squaredRest(d) > kDependent, size < 6.
  [[gnu::noinline]] void add(std::uint32_t r, double b, double u, double d[6]) {
    // One reflection maps the remainder of the normal onto the next column of Q.
    const double rest = std::sqrt(squaredRest(d)), length = d[size] > 0 ? -rest : rest, scale = 1 / (rest * (rest + std::abs(d[size])));
    d[size] -= length;
    double across[6] = {};
    for (int j = size; j < 6; ++j)
      for (int i = 0; i < 6; ++i) across[i] += d[j] * q_[j][i];
    for (int j = size; j < 6; ++j)
      for (int i = 0; i < 6; ++i) q_[j][i] -= scale * d[j] * across[i];
    d[size] = length;
    for (int i = 0; i <= size; ++i) r_[i][size] = d[i];
    row[size] = r;
    bound[size] = b;
    multiplier[size] = u;
    ++size;
  }

  [[gnu::noinline]] void drop(int k) {
    for (int j = k; j + 1 < size; ++j) {
      row[j] = row[j + 1];
      bound[j] = bound[j + 1];
      multiplier[j] = multiplier[j + 1];
      for (int i = 0; i <= j + 1; ++i) r_[i][j] = r_[i][j + 1];
    }
    --size;
    for (int j = k; j < size; ++j) {
      const double a = r_[j][j], b = r_[j + 1][j], length = std::sqrt(a * a + b * b);
      if (b == 0 || length == 0) continue;
      const double c = a / length, s = b / length;
      for (int i = j; i < size; ++i) {
        const double top = r_[j][i], low = r_[j + 1][i];
        r_[j][i] = c * top + s * low;
        r_[j + 1][i] = c * low - s * top;
      }
      turn(q_[j], q_[j + 1], c, s);
    }
  }

  // The point nearest to `target` on all active rows; sets the multipliers.
  [[gnu::noinline]] Vector6 nearest(const Vector6& target) {
    double w[6] = {};
    for (int j = 0; j < size; ++j) {  // R^T w = bound - N^T target, with N = Q R
      double sum = bound[j];
      for (int i = 0; i < j; ++i) sum -= r_[i][j] * w[i];
      w[j] = sum / r_[j][j];
    }
    // w has the coordinates of the solution along Q; the multipliers solve R u = w - Q^T target.
    double d[6], u[6] = {};
    project(target, d);
    Vector6 y = rest(d);
    for (int j = 0; j < size; ++j) {
      for (int i = 0; i < 6; ++i) y[i] += w[j] * q_[j][i];
      d[j] = w[j] - d[j];
    }
    solve(d, u);
    for (int j = 0; j < size; ++j) multiplier[j] = u[j];
    return y;
  }

 private:
  static void turn(double a[6], double b[6], double c, double s) {
    for (int i = 0; i < 6; ++i) {
      const double x = a[i], y = b[i];
      a[i] = c * x + s * y;
      b[i] = c * y - s * x;
    }
  }
  double q_[6][6];       // column j of Q is q_[j]
  double r_[6][6] = {};  // r_[row][column]
};

Vector6 normalOf(const QpRows& rows, std::uint32_t i) {
  Vector6 n;
  for (int k = 0; k < 6; ++k) n[k] = static_cast<double>(rows.a[static_cast<std::size_t>(k)][i]);
  return n;
}

/// Adds the previously active rows to `set`, and returns a dual feasible start: the nearest point on them, without rows
/// whose multiplier would be negative.
Vector6 warmStart(const QpRows& rows, const Vector6& target, const QpAnswer& before, ActiveSet& set) {
  double d[6];
  for (int k = 0; k < before.active_count; ++k) {
    const std::uint32_t i = before.active[static_cast<std::size_t>(k)];
    if (i >= rows.count || set.has(i) || set.size == 6) continue;
    set.project(normalOf(rows, i), d);
    if (set.squaredRest(d) > 1e-6) set.add(i, static_cast<double>(rows.b[i]), 0, d);  // strict: a poor start costs more than none
  }
  Vector6 y = set.nearest(target);
  while (set.size > 0) {
    int smallest = 0;
    for (int k = 1; k < set.size; ++k)
      if (set.multiplier[k] < set.multiplier[smallest]) smallest = k;
    if (set.multiplier[smallest] >= 0) break;
    set.drop(smallest);
    y = set.nearest(target);
  }
  return y;
}

/// The row that enters next, that is the most violated one; rows.count if none is violated.
std::uint32_t violatedRow(const KernelTable& kernel, const QpRows& rows, const Vector6& y, const ActiveSet& set) {
  float scan[6];
  double largest = 0;
  for (int k = 0; k < 6; ++k) {
    scan[k] = static_cast<float>(y[k]);
    largest = std::max(largest, std::abs(y[k]));
  }
  const WorstRow worst = kernel.worstRow(rows.a.data(), rows.b, rows.count, scan);
  if (!(static_cast<double>(worst.slack) < -(kQpTolerance + 1e-6 * largest))) return rows.count;
  return set.has(worst.row) ? rows.count : worst.row;  // the row is active: its violation is rounding
}

/// The row and the active ones, with weights `r`, add up to 0 >= a positive number.
void proveInfeasible(std::uint32_t row, const ActiveSet& set, const double (&r)[6], QpAnswer& answer) {
  answer.status = QpStatus::Infeasible;
  answer.certificate[0] = row;
  answer.certificate_weight[0] = 1;
  answer.certificate_count = 1;
  for (int k = 0; k < set.size; ++k)
    if (r[k] < -1e-12) {
      answer.certificate[answer.certificate_count] = set.row[k];
      answer.certificate_weight[answer.certificate_count++] = -r[k];
    }
}

/// Moves `y` onto the row, which becomes active; rows whose multiplier would be negative leave. Returns false if that
/// fails: either the rows contradict each other, with the certificate in `answer`, or the row was violated only in
/// float.
bool takeIn(std::uint32_t row, const QpRows& rows, ActiveSet& set, Vector6& y, QpAnswer& answer) {
  const Vector6 normal = normalOf(rows, row);
  const double bound = static_cast<double>(rows.b[row]);
  double d[6], r[6], entering = 0;
  for (;;) {
    set.project(normal, d);
    set.solve(d, r);
    const double rest = set.squaredRest(d), slack = normal.dot(y) - bound;
    if (slack >= 0) return false;
    int blocking = -1;
    double partial = kInfinity;
    for (int k = 0; k < set.size; ++k)
      if (r[k] > 1e-12 && set.multiplier[k] < partial * r[k]) {
        partial = set.multiplier[k] / r[k];
        blocking = k;
      }
    const double full = rest > kDependent ? -slack / rest : kInfinity;
    if (blocking < 0 && full == kInfinity) {
      proveInfeasible(row, set, r, answer);
      return false;
    }
    const double length = std::min(partial, full);
    for (int k = 0; k < set.size; ++k) set.multiplier[k] -= length * r[k];
    entering += length;
    if (full < kInfinity) y += length * set.rest(d);
    if (full <= partial) {
      set.add(row, bound, entering, d);
      return true;
    }
    set.drop(blocking);
  }
}

}  // namespace

void solveQp6(const KernelTable& kernel, const QpRows& rows, const Vector6& target, QpAnswer& answer) noexcept {
  ActiveSet set;
  Vector6 y = warmStart(rows, target, answer, set);
  answer = QpAnswer{};
  while (rows.count > 0) {
    const std::uint32_t row = violatedRow(kernel, rows, y, set);
    if (row == rows.count) break;
    if (answer.iterations == kQpIterationLimit) {
      answer.status = QpStatus::IterationLimit;
      break;
    }
    ++answer.iterations;
    if (!takeIn(row, rows, set, y, answer)) break;
  }
  // Removes accumulated rounding errors. If rounding ended a step between two corners, the active rows are an equally
  // good solution.
  if (answer.status == QpStatus::Optimal && answer.iterations > 0) y = set.nearest(target);
  answer.y = y;
  answer.active_count = static_cast<std::uint8_t>(set.size);
  for (int k = 0; k < set.size; ++k) {
    answer.active[static_cast<std::size_t>(k)] = set.row[k];
    answer.multiplier[static_cast<std::size_t>(k)] = set.multiplier[k];
  }
}

}  // namespace spheretree::runtime
