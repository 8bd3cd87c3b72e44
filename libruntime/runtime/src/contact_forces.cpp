// SPDX-License-Identifier: Apache-2.0
#include "contact_forces.h"

#include <algorithm>
#include <cmath>

namespace spheretree::runtime {
namespace {

constexpr double kYield = 1e-9;  // of what a force does to itself, that it gives way: rows that say the same are then no harm
constexpr int kMaxChanges = 8 * kMaxContactRows;
// What a change of the rows costs, and more for each row; products of which one group of rows is worth so many.
constexpr std::uint32_t kChangeWork = 40, kRowWork = 5, kSweepShare = 4, kDenseShare = 16;
constexpr int kSweeps = 20, kMaxRounds = 20;  // between two steps of Newton's method; of both

class Forces {
 public:
  Forces(ContactQp& qp, const SurfaceCompliance& compliance);
  bool solveRows();
  void solveAll();
  std::uint32_t work() const { return work_; }

 private:
  using Vector = std::array<double, kMaxForces>;

  bool solvePressing();
  void leaveOut(std::size_t index);
  void keep();

  void findMotions();
  void change(std::size_t force, double by);
  double radiusOf(std::size_t disc) const;
  void project(std::size_t disc, double& f0, double& f1) const;
  void sweep();
  double residual();
  bool newtonStep();
  void addEquations(std::size_t disc, std::size_t at);
  bool solveDense(std::size_t size);

  std::uint32_t work_ = 0;

  ContactQp& qp_;
  const std::size_t rows_, discs_, count_;  // forces are those of the rows and then two of each disc
  std::array<Vector, kMaxForces> g_;
  Vector q_, p_, w_;
  // Without discs.
  Vector solved_;
  std::array<std::size_t, kMaxContactRows> pressing_;  // rows, in the order of their factor
  std::size_t pressing_count_ = 0;
  // Newton's method: the forces that it changes, and its equations.
  std::array<std::size_t, kMaxForces> changed_;
  std::size_t changed_count_ = 0;
  std::array<Vector, kMaxForces> matrix_;
  Vector right_;
};

Forces::Forces(ContactQp& qp, const SurfaceCompliance& compliance)
    : qp_(qp), rows_(static_cast<std::size_t>(qp.row_count)), discs_(static_cast<std::size_t>(qp.disc_count)), count_(rows_ + 2 * discs_) {
  const auto across = [&](std::size_t i) -> const Vector6& { return qp.discs[(i - rows_) / 2].across[(i - rows_) % 2]; };
  const auto side = [&](std::size_t i) -> const Vector6& { return i < rows_ ? qp.rows[i].a : across(i); };
  const auto surface = [&](std::size_t i) { return i < rows_ ? i : kMaxContactRows + i - rows_; };
  for (std::size_t i = 0; i < count_; ++i) {
    for (std::size_t j = 0; j <= i; ++j) g_[i][j] = side(i).dot(side(j)) + compliance[surface(i)][surface(j)];
    q_[i] = side(i).dot(qp.target);
    if (i >= rows_) {
      const FrictionDisc& d = qp.discs[(i - rows_) / 2];
      q_[i] -= d.origin[(i - rows_) % 2];
      p_[i] = d.force[(i - rows_) % 2];
      continue;
    }
    const ContactRow& r = qp.rows[i];
    q_[i] -= r.b;
    if (r.group >= 0) q_[i] += r.give * qp.rest[static_cast<std::size_t>(r.group)];
    for (std::size_t j = 0; j <= i && r.group >= 0; ++j)
      if (qp.rows[j].group == r.group) g_[i][j] += r.give * qp.rows[j].give;
    g_[i][i] += r.compliance;
    p_[i] = std::max(0.0, r.multiplier);
    if (p_[i] > 0) pressing_[pressing_count_++] = i;
  }
  for (std::size_t i = 0; i < count_; ++i) {
    g_[i][i] *= 1 + kYield;
    for (std::size_t j = 0; j < i; ++j) g_[j][i] = g_[i][j];
  }
}

// Of the rows that press the multipliers with which none of them is violated or slack.
bool Forces::solvePressing() {
  double l[kMaxContactRows][kMaxContactRows];
  Vector& b = solved_;
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
  return true;
}

void Forces::leaveOut(std::size_t index) {
  p_[pressing_[index]] = 0;
  std::copy(pressing_.begin() + static_cast<std::ptrdiff_t>(index) + 1, pressing_.begin() + static_cast<std::ptrdiff_t>(pressing_count_),
            pressing_.begin() + static_cast<std::ptrdiff_t>(index));
  --pressing_count_;
}

bool Forces::solveRows() {
  for (int change = 0; change < kMaxChanges; ++change) {
    ++qp_.iterations;
    work_ += kChangeWork + kRowWork * static_cast<std::uint32_t>(rows_);
    if (!solvePressing()) return false;
    // As far towards them as no row comes to pull.
    double part = 1;
    std::size_t first = pressing_count_;
    for (std::size_t i = 0; i < pressing_count_; ++i) {
      const double u = p_[pressing_[i]];
      if (solved_[i] > 0 || !(u < part * (u - solved_[i]) || (u == 0 && first == pressing_count_))) continue;
      part = u > 0 ? u / (u - solved_[i]) : 0;
      first = i;
    }
    for (std::size_t i = 0; i < pressing_count_; ++i) p_[pressing_[i]] += part * (solved_[i] - p_[pressing_[i]]);
    if (first < pressing_count_) {
      leaveOut(first);
      continue;
    }
    double worst = -0.1 * qp_.tolerance;
    std::size_t violated = rows_;
    for (std::size_t i = 0; i < rows_; ++i) {
      if (p_[i] > 0) continue;
      double w = q_[i];
      for (std::size_t k = 0; k < pressing_count_; ++k) w += g_[i][pressing_[k]] * p_[pressing_[k]];
      if (w < worst) worst = w, violated = i;
    }
    if (violated == rows_) {
      qp_.converged = true;
      keep();
      return true;
    }
    pressing_[pressing_count_++] = violated;
  }
  return false;
}

// Tool, groups and forces of the problem, from the forces.
void Forces::keep() {
  qp_.y = qp_.target;
  qp_.given = qp_.rest;
  for (std::size_t i = 0; i < rows_; ++i) {
    ContactRow& r = qp_.rows[i];
    r.multiplier = p_[i];
    if (!(p_[i] > 0)) continue;
    qp_.y += p_[i] * r.a;
    if (r.group >= 0) qp_.given[static_cast<std::size_t>(r.group)] += p_[i] * r.give;
  }
  for (std::size_t d = 0; d < discs_; ++d)
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double f = p_[rows_ + 2 * d + axis];
      qp_.discs[d].force[axis] = f;
      qp_.y += f * qp_.discs[d].across[axis];
    }
}

void Forces::findMotions() {
  w_ = q_;
  for (std::size_t j = 0; j < count_; ++j)
    for (std::size_t i = 0; p_[j] != 0 && i < count_; ++i) w_[i] += p_[j] * g_[j][i];
}

void Forces::change(std::size_t force, double by) {
  if (by == 0) return;
  p_[force] += by;
  for (std::size_t i = 0; i < count_; ++i) w_[i] += by * g_[force][i];
}

double Forces::radiusOf(std::size_t disc) const {
  const FrictionDisc& d = qp_.discs[disc];
  return d.law > 0 ? d.law * p_[static_cast<std::size_t>(d.row)] : d.radius;
}

// The nearest force that the disc allows.
void Forces::project(std::size_t disc, double& f0, double& f1) const {
  const double radius = radiusOf(disc), square = f0 * f0 + f1 * f1;
  if (square <= radius * radius) return;
  const double scale = radius / std::sqrt(square);
  f0 *= scale, f1 *= scale;
}

// Each row the best that it can be with the others as they are; of a disc the force that would let it stick, or, if it
// may not have that, the nearest to that of a step against the slip.
void Forces::sweep() {
  for (std::size_t i = 0; i < rows_; ++i) change(i, std::max(-p_[i], -w_[i] / g_[i][i]));
  for (std::size_t d = 0; d < discs_; ++d) {
    const std::size_t i = rows_ + 2 * d;
    const double v0 = w_[i], v1 = w_[i + 1], a = g_[i][i], b = g_[i][i + 1], c = g_[i + 1][i + 1], det = a * c - b * b;
    double f0 = p_[i] - (c * v0 - b * v1) / det, f1 = p_[i + 1] - (a * v1 - b * v0) / det;
    const double radius = radiusOf(d);
    if (f0 * f0 + f1 * f1 > radius * radius) {
      const double step = 1 / (a + c);
      f0 = p_[i] - step * v0, f1 = p_[i + 1] - step * v1;
      project(d, f0, f1);
    }
    change(i, f0 - p_[i]);
    change(i + 1, f1 - p_[i + 1]);
  }
}

// How far the motions are from what the law asks for, at most [mm, scaled]; leaves them in w_.
double Forces::residual() {
  double largest = 0;
  findMotions();
  for (std::size_t i = 0; i < rows_; ++i) largest = std::max(largest, std::abs(std::max(-w_[i], -g_[i][i] * p_[i])));
  for (std::size_t d = 0; d < discs_; ++d) {
    const std::size_t i = rows_ + 2 * d;
    const double size = g_[i][i] + g_[i + 1][i + 1];
    double f0 = p_[i] - w_[i] / size, f1 = p_[i + 1] - w_[i + 1] / size;
    project(d, f0, f1);
    largest = std::max(largest, size * std::hypot(f0 - p_[i], f1 - p_[i + 1]));
  }
  return largest;
}

// Of a disc the two equations: it sticks, v = 0, or f = radius z / |z| with z = f - v / size, linearised.
void Forces::addEquations(std::size_t disc, std::size_t at) {
  const std::size_t i = rows_ + 2 * disc, row = static_cast<std::size_t>(qp_.discs[disc].row);
  const double size = g_[i][i] + g_[i + 1][i + 1], z0 = p_[i] - w_[i] / size, z1 = p_[i + 1] - w_[i + 1] / size,
               length = std::hypot(z0, z1), radius = radiusOf(disc);
  const bool slips = length > radius;
  const double d[2] = {slips ? z0 / length : 0, slips ? z1 / length : 0}, across = slips ? radius / length : 0;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    Vector& equation = matrix_[at + axis];
    const double along0 = (axis == 0 ? 1 : 0) - d[axis] * d[0], along1 = (axis == 1 ? 1 : 0) - d[axis] * d[1];
    for (std::size_t k = 0; k < changed_count_; ++k) {
      const std::size_t j = changed_[k];
      if (!slips) {
        equation[k] = g_[i + axis][j];
        continue;
      }
      equation[k] = across * (along0 * g_[i][j] + along1 * g_[i + 1][j]) / size;
      if (j == i + axis) equation[k] += 1;
      if (j == i) equation[k] -= across * along0;
      if (j == i + 1) equation[k] -= across * along1;
      if (j == row && qp_.discs[disc].law > 0) equation[k] -= qp_.discs[disc].law * d[axis];
    }
    right_[at + axis] = slips ? radius * d[axis] - p_[i + axis] : -w_[i + axis];
  }
}

// By Gauss's elimination with pivots; the answer is in right_.
bool Forces::solveDense(std::size_t size) {
  for (std::size_t k = 0; k < size; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < size; ++i)
      if (std::abs(matrix_[i][k]) > std::abs(matrix_[pivot][k])) pivot = i;
    if (!(std::abs(matrix_[pivot][k]) > 1e-14)) return false;
    if (pivot != k) {
      std::swap_ranges(matrix_[k].begin() + static_cast<std::ptrdiff_t>(k), matrix_[k].begin() + static_cast<std::ptrdiff_t>(size),
                       matrix_[pivot].begin() + static_cast<std::ptrdiff_t>(k));
      std::swap(right_[k], right_[pivot]);
    }
    for (std::size_t i = k + 1; i < size; ++i) {
      const double factor = matrix_[i][k] / matrix_[k][k];
      if (factor == 0) continue;
      for (std::size_t j = k + 1; j < size; ++j) matrix_[i][j] -= factor * matrix_[k][j];
      right_[i] -= factor * right_[k];
    }
  }
  for (std::size_t i = size; i-- > 0;) {
    for (std::size_t j = i + 1; j < size; ++j) right_[i] -= matrix_[i][j] * right_[j];
    right_[i] /= matrix_[i][i];
  }
  return true;
}

// From the motions of residual(): of the rows that press or should, and of their discs.
bool Forces::newtonStep() {
  changed_count_ = 0;
  std::array<bool, kMaxContactRows> presses{};
  for (std::size_t i = 0; i < rows_; ++i)
    if (presses[i] = g_[i][i] * p_[i] > w_[i]; presses[i]) changed_[changed_count_++] = i;
  const std::size_t pressing = changed_count_;
  for (std::size_t i = 0; i < rows_; ++i)
    if (!presses[i]) p_[i] = 0;
  for (std::size_t d = 0; d < discs_; ++d) {
    const std::size_t i = rows_ + 2 * d;
    if (radiusOf(d) > 0 && (presses[static_cast<std::size_t>(qp_.discs[d].row)] || !(qp_.discs[d].law > 0)))
      changed_[changed_count_] = i, changed_[changed_count_ + 1] = i + 1, changed_count_ += 2;
    else
      p_[i] = p_[i + 1] = 0;
  }
  findMotions();
  for (std::size_t k = 0; k < pressing; ++k) {
    for (std::size_t j = 0; j < changed_count_; ++j) matrix_[k][j] = g_[changed_[k]][changed_[j]];
    right_[k] = -w_[changed_[k]];
  }
  for (std::size_t k = pressing; k < changed_count_; k += 2) addEquations((changed_[k] - rows_) / 2, k);
  work_ += static_cast<std::uint32_t>(changed_count_ * changed_count_ * changed_count_) / kDenseShare;
  if (!solveDense(changed_count_)) return false;
  for (std::size_t k = 0; k < changed_count_; ++k) p_[changed_[k]] += right_[k];
  for (std::size_t i = 0; i < rows_; ++i) p_[i] = std::max(0.0, p_[i]);
  for (std::size_t d = 0; d < discs_; ++d) project(d, p_[rows_ + 2 * d], p_[rows_ + 2 * d + 1]);
  return true;
}

void Forces::solveAll() {
  for (std::size_t d = 0; d < discs_; ++d) project(d, p_[rows_ + 2 * d], p_[rows_ + 2 * d + 1]);
  double left = residual();
  for (int round = 0; round < kMaxRounds && !(left <= 0.1 * qp_.tolerance); ++round) {
    ++qp_.iterations;
    work_ += static_cast<std::uint32_t>(count_ * count_) / kSweepShare;
    const Vector before = p_;
    double next = newtonStep() ? residual() : left;
    if (!(next < 0.5 * left)) {  // it came no nearer from there
      p_ = before;
      findMotions();
      for (int n = 0; n < kSweeps; ++n) sweep();
      work_ += static_cast<std::uint32_t>(kSweeps * count_ * count_) / kDenseShare;
      next = residual();
    }
    left = next;
  }
  qp_.converged = left <= qp_.tolerance;
  keep();
}

}  // namespace

std::uint32_t solveForces(ContactQp& qp, const SurfaceCompliance& compliance) noexcept {
  qp.iterations = 0;
  qp.converged = false;
  Forces forces(qp, compliance);
  if (qp.disc_count > 0 || !forces.solveRows()) forces.solveAll();
  return forces.work();
}

}  // namespace spheretree::runtime
