// SPDX-License-Identifier: Apache-2.0
// The problem without discs, formulated in the multipliers u of its rows:  w = q + G u,  u >= 0,  w >= 0,  u . w = 0,
// where G is positive definite. An active-set method: it solves for the active rows, removes a row whose multiplier
// becomes negative, and adds the most violated row. The objective decreases with each change, so no active set occurs
// twice.
// Paper: C. Lawson, R. Hanson. Solving Least Squares Problems. Prentice Hall 1974, chapter 23.
#include <algorithm>
#include <cmath>

#include "contact_qp.h"

namespace spheretree::runtime {
namespace {

constexpr double kYield = 1e-9;  // relative compliance added to each row, so that identical rows do no harm
constexpr int kMostChanges = 8 * kMostContactRows;

class RowsAlone {
 public:
  explicit RowsAlone(ContactQp& qp);
  bool solve();

 private:
  bool solvePressing();
  void leaveOut(std::size_t index);

  using Vector = std::array<double, kMostContactRows>;

  ContactQp& qp_;
  const std::size_t count_;
  std::array<Vector, kMostContactRows> g_;
  Vector q_, u_, solved_;
  std::array<std::size_t, kMostContactRows> pressing_;  // active rows, in the order of their factor
  std::size_t pressing_count_ = 0;
};

RowsAlone::RowsAlone(ContactQp& qp) : qp_(qp), count_(static_cast<std::size_t>(qp.row_count)) {
  const auto coordinates = static_cast<std::size_t>(qp.tissue_count);
  for (std::size_t i = 0; i < count_; ++i) {
    const ContactRow& r = qp.rows[i];
    q_[i] = r.a.dot(qp.target) - r.b;
    if (r.group >= 0) q_[i] += r.give * qp.rest[static_cast<std::size_t>(r.group)];
    for (std::size_t j = 0; j <= i; ++j) {
      const ContactRow& other = qp.rows[j];
      double sum = r.a.dot(other.a);
      if (r.group >= 0 && r.group == other.group) sum += r.give * other.give;
      for (std::size_t m = 0; m < coordinates; ++m) sum += qp.tissue[i][m] * qp.tissue[j][m];
      g_[i][j] = g_[j][i] = sum;
    }
    g_[i][i] = (g_[i][i] + r.compliance) * (1 + kYield);
    u_[i] = std::max(0.0, r.multiplier);
    if (u_[i] > 0) pressing_[pressing_count_++] = i;
  }
}

// Computes the multipliers with which no active row is violated or slack.
bool RowsAlone::solvePressing() {
  double l[kMostContactRows][kMostContactRows];
  Vector b;
  for (std::size_t i = 0; i < pressing_count_; ++i) {
    b[i] = -q_[pressing_[i]];
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = g_[pressing_[i]][pressing_[j]];
      for (std::size_t k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j && !(sum > 0)) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
      if (j < i) b[i] -= l[i][j] * b[j];
    }
    b[i] /= l[i][i];
  }
  for (std::size_t i = pressing_count_; i-- > 0;) {
    for (std::size_t k = i + 1; k < pressing_count_; ++k) b[i] -= l[k][i] * b[k];
    b[i] /= l[i][i];
  }
  std::copy_n(b.begin(), pressing_count_, solved_.begin());
  return true;
}

void RowsAlone::leaveOut(std::size_t index) {
  u_[pressing_[index]] = 0;
  std::copy(pressing_.begin() + static_cast<std::ptrdiff_t>(index) + 1, pressing_.begin() + static_cast<std::ptrdiff_t>(pressing_count_),
            pressing_.begin() + static_cast<std::ptrdiff_t>(index));
  --pressing_count_;
}

bool RowsAlone::solve() {
  for (int change = 0; change < kMostChanges; ++change) {
    ++qp_.iterations;
    if (!solvePressing()) return false;
    // Moves towards them as far as all multipliers stay nonnegative.
    double part = 1;
    std::size_t first = pressing_count_;
    for (std::size_t i = 0; i < pressing_count_; ++i) {
      const double u = u_[pressing_[i]];
      if (solved_[i] > 0 || !(u < part * (u - solved_[i]) || (u == 0 && first == pressing_count_))) continue;
      part = u > 0 ? u / (u - solved_[i]) : 0;
      first = i;
    }
    for (std::size_t i = 0; i < pressing_count_; ++i) u_[pressing_[i]] += part * (solved_[i] - u_[pressing_[i]]);
    if (first < pressing_count_) {
      leaveOut(first);
      continue;
    }
    double worst = -0.1 * qp_.tolerance;
    std::size_t violated = count_;
    for (std::size_t i = 0; i < count_; ++i) {
      if (u_[i] > 0) continue;
      double w = q_[i];
      for (std::size_t k = 0; k < pressing_count_; ++k) w += g_[i][pressing_[k]] * u_[pressing_[k]];
      if (w < worst) worst = w, violated = i;
    }
    if (violated == count_) break;
    pressing_[pressing_count_++] = violated;
    if (change + 1 == kMostChanges) return false;
  }
  qp_.y = qp_.target;
  qp_.given = qp_.rest;
  qp_.tissue_given.fill(0);
  for (std::size_t i = 0; i < count_; ++i) {
    ContactRow& r = qp_.rows[i];
    r.multiplier = u_[i];
    if (!(u_[i] > 0)) continue;
    qp_.y += u_[i] * r.a;
    if (r.group >= 0) qp_.given[static_cast<std::size_t>(r.group)] += u_[i] * r.give;
    for (std::size_t m = 0; m < static_cast<std::size_t>(qp_.tissue_count); ++m) qp_.tissue_given[m] += u_[i] * qp_.tissue[i][m];
  }
  return true;
}

}  // namespace

bool solveRowsAlone(ContactQp& qp) noexcept { return RowsAlone(qp).solve(); }

}  // namespace spheretree::runtime
