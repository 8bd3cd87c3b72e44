// SPDX-License-Identifier: Apache-2.0
#include "contact/contact_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spheretree::runtime {
namespace {

constexpr double kYield = 1e-9;  // relative compliance that is added to each force, so that equal rows have one solution
constexpr int kMaxChanges = 8 * kMaxContactRows;
// Work of a change of the active rows, and of each row in it; numbers of products that are as much work as one unit.
constexpr std::uint32_t kChangeWork = 40, kRowWork = 5, kSweepShare = 4, kDenseShare = 16;
constexpr int kMaxRounds = 12;
// Sweeps over the contacts before Newton's method, and after a step that does not halve the residual: more each time,
// up to a number in all. A problem that has not converged by then may have no answer; with more sweeps steps come too
// late for the hand, and the forces are no smoother.
constexpr double kFirstSweeps = 10, kSweeps = 20, kSweepGrowth = 1.5, kMaxSweeps = 400;
constexpr double kDamping = 1e-4;  // of the diagonal: contacts side by side have nearly the same equations
constexpr double kSteepness = 10;  // of residual(), in Newton's method
constexpr double kSolved = 0.02;   // share of the tolerance at which Newton's method stops
constexpr std::array<double, 5> kShares{1, 0.5, 0.25, 0.125, 0.0625};  // of a Newton step, in the order in which they are tried
constexpr double kDecrease = 0.1;                                      // share of the residual by which a whole step must lower it

class Forces {
 public:
  Forces(ContactQp& qp, const SurfaceCompliance& compliance);
  void holdFriction();
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
  void projectAll();
  void sweep();
  void sweeps(double count);
  double sizeOf(std::size_t disc) const { return g_[rows_ + 2 * disc][rows_ + 2 * disc] + g_[rows_ + 2 * disc + 1][rows_ + 2 * disc + 1]; }
  double damped(std::size_t i, std::size_t j) const { return i == j ? (1 + kDamping) * g_[i][i] : g_[i][j]; }
  double residual(double steepness);
  bool newtonStep();
  double goAlong(double left);
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

void Forces::holdFriction() {
  for (std::size_t j = rows_; j < count_; ++j)
    for (std::size_t i = 0; i < rows_; ++i) q_[i] += p_[j] * g_[j][i];
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
    double share = 1;
    std::size_t first = pressing_count_;
    for (std::size_t i = 0; i < pressing_count_; ++i) {
      const double u = p_[pressing_[i]];
      if (solved_[i] > 0 || !(u < share * (u - solved_[i]) || (u == 0 && first == pressing_count_))) continue;
      share = u > 0 ? u / (u - solved_[i]) : 0;
      first = i;
    }
    for (std::size_t i = 0; i < pressing_count_; ++i) p_[pressing_[i]] += share * (solved_[i] - p_[pressing_[i]]);
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

void Forces::projectAll() {
  for (std::size_t d = 0; d < discs_; ++d) project(d, p_[rows_ + 2 * d], p_[rows_ + 2 * d + 1]);
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

// How far the motions are from what the law asks for, at most [mm, scaled]; leaves them in w_. A force of a disc obeys
// the law if it is the nearest allowed one to  f - `steepness` v / size,  for any steepness.
double Forces::residual(double steepness) {
  double largest = 0;
  findMotions();
  for (std::size_t i = 0; i < rows_; ++i) largest = std::max(largest, std::abs(std::max(-w_[i], -g_[i][i] * p_[i])));
  for (std::size_t d = 0; d < discs_; ++d) {
    const std::size_t i = rows_ + 2 * d;
    const double size = sizeOf(d) / steepness;
    double f0 = p_[i] - w_[i] / size, f1 = p_[i + 1] - w_[i + 1] / size;
    project(d, f0, f1);
    largest = std::max(largest, size * std::hypot(f0 - p_[i], f1 - p_[i + 1]));
  }
  return largest;
}

// Of a disc the two equations: it sticks, v = 0, or f = radius z / |z| with z = f - v / size, linearised. The
// derivative of the direction of z is taken with the share of f that the disc allows in place of z (Hueber et al.): it
// is the same in a solution, and keeps the step short where f is far from there.
void Forces::addEquations(std::size_t disc, std::size_t at) {
  const std::size_t i = rows_ + 2 * disc, row = static_cast<std::size_t>(qp_.discs[disc].row);
  const double size = sizeOf(disc) / kSteepness, z0 = p_[i] - w_[i] / size, z1 = p_[i + 1] - w_[i + 1] / size, length = std::hypot(z0, z1),
               radius = radiusOf(disc);
  if (length <= radius) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      for (std::size_t k = 0; k < changed_count_; ++k) matrix_[at + axis][k] = damped(i + axis, changed_[k]);
      right_[at + axis] = -w_[i + axis];
    }
    return;
  }
  const double to[2] = {z0 / length, z1 / length}, share = radius / length, allowed = std::max(radius, std::hypot(p_[i], p_[i + 1]));
  for (std::size_t axis = 0; axis < 2; ++axis) {
    Vector& equation = matrix_[at + axis];
    const double turn0 = share * ((axis == 0 ? 1 : 0) - to[axis] * p_[i] / allowed),
                 turn1 = share * ((axis == 1 ? 1 : 0) - to[axis] * p_[i + 1] / allowed);
    for (std::size_t k = 0; k < changed_count_; ++k) {
      const std::size_t j = changed_[k];
      equation[k] = turn0 * damped(i, j) + turn1 * damped(i + 1, j);
      if (j == i + axis) equation[k] += size;
      if (j == i) equation[k] -= size * turn0;
      if (j == i + 1) equation[k] -= size * turn1;
      if (j == row && qp_.discs[disc].law > 0) equation[k] -= size * qp_.discs[disc].law * to[axis];
    }
    right_[at + axis] = size * (radius * to[axis] - p_[i + axis]);
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

// From the motions of residual(), for the rows that press or should and their discs; the forces of the others are 0
// from now on. The step is in right_.
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
    for (std::size_t j = 0; j < changed_count_; ++j) matrix_[k][j] = damped(changed_[k], changed_[j]);
    right_[k] = -w_[changed_[k]];
  }
  for (std::size_t k = pressing; k < changed_count_; k += 2) addEquations((changed_[k] - rows_) / 2, k);
  work_ += static_cast<std::uint32_t>(changed_count_ * changed_count_ * changed_count_) / kDenseShare;
  return solveDense(changed_count_);
}

// Takes the first share of the step that lowers the residual or, if none does, the one with the smallest. Returns it.
double Forces::goAlong(double left) {
  const Vector from = p_;
  double smallest = std::numeric_limits<double>::infinity(), best = 0;
  const auto go = [&](double share) {
    p_ = from;
    for (std::size_t k = 0; k < changed_count_; ++k) p_[changed_[k]] += share * right_[k];
    for (std::size_t i = 0; i < rows_; ++i) p_[i] = std::max(0.0, p_[i]);
    return residual(kSteepness);
  };
  for (const double share : kShares) {
    const double next = go(share);
    if (next < smallest) smallest = next, best = share;
    if (next < (1 - kDecrease * share) * left) return next;
  }
  return go(best);
}

void Forces::sweeps(double count) {
  projectAll();
  findMotions();
  const auto n = static_cast<std::size_t>(count);
  for (std::size_t i = 0; i < n; ++i) sweep();
  work_ += static_cast<std::uint32_t>(n * count_ * count_) / kDenseShare;
}

void Forces::solveAll() {
  sweeps(kFirstSweeps);
  double left = residual(kSteepness), count = kSweeps, swept = 0;
  for (int round = 0; round < kMaxRounds && !(left <= kSolved * qp_.tolerance); ++round) {
    ++qp_.iterations;
    work_ += static_cast<std::uint32_t>(count_ * count_) / kSweepShare;
    const double before = left;
    if (newtonStep()) left = goAlong(left);
    if (left < 0.5 * before || swept >= kMaxSweeps) continue;
    const Vector reached = p_;
    sweeps(count);
    swept += count;
    count *= kSweepGrowth;
    if (const double next = residual(kSteepness); next < left)
      left = next;
    else
      p_ = reached, findMotions();
  }
  projectAll();
  qp_.converged = residual(1) <= qp_.tolerance;
  keep();
}

}  // namespace

std::uint32_t solveForces(ContactQp& qp, const SurfaceCompliance& compliance) noexcept {
  qp.iterations = 0;
  qp.converged = false;
  Forces forces(qp, compliance);
  if (qp.holds_friction) {
    forces.holdFriction();
    forces.solveRows();
  } else if (qp.disc_count > 0 || !forces.solveRows()) {
    forces.solveAll();
  }
  return forces.work();
}

}  // namespace spheretree::runtime
