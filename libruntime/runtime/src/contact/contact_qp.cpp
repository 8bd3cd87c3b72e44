// SPDX-License-Identifier: Apache-2.0
#include "contact/contact_qp.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace spheretree::runtime {
namespace {

constexpr int kMaxCoordinates = 6 + kMaxGroups;
static_assert(kMaxCoordinates % 2 == 0);
// Penalties of the augmented Lagrangian, round by round [1]. With nearly correct multipliers a large penalty is best;
// otherwise the inner problem is smoother with a small one.
constexpr double kLawPenalty = 3e4, kWarmPenalty = 1e5, kMinPenalty = 30, kPenaltyGrowth = 10, kMaxPenalty = 1e6;
constexpr int kWarmNewtonSteps = 25;      // if these do not suffice, the initial multipliers were no good guess
constexpr int kMaxMultiplierRounds = 20;  // rounds of multiplier updates
constexpr int kMaxNewtonSteps = 200;      // over all rounds
constexpr int kMaxShorterSteps = 30;
constexpr int kWholeSteps = 4;  // for Coulomb's law; then a step may be shortened
constexpr std::array<double, 4> kShorterParts{0.5, 0.25, 0.1, 0.03};
constexpr double kSlips = 1 - 1e-9;      // a force of this share of its squared radius is that of a slipping contact
constexpr std::size_t kSmallSystem = 3;  // of one contact with friction: the Newton step is found from their equations

using Coordinates = std::array<double, kMaxCoordinates>;
typedef double D2 __attribute__((vector_size(16)));

D2 load(const double* p) {
  D2 v;
  std::memcpy(&v, p, sizeof v);
  return v;
}
void store(double* p, D2 v) { std::memcpy(p, &v, sizeof v); }
D2 splat(double v) { return D2{v, v}; }

// `size` is even, as in dot(). The loops over six coordinates are written out: at -O2 they would stay loops.
void addTimes(double* to, double factor, const double* of, std::size_t size) {
  for (std::size_t j = 0; j < size; j += 2) store(to + j, load(to + j) + splat(factor) * load(of + j));
}
void addTimes(double* to, double factor, const double* of) {
  const D2 f = splat(factor);
  store(to, load(to) + f * load(of));
  store(to + 2, load(to + 2) + f * load(of + 2));
  store(to + 4, load(to + 4) + f * load(of + 4));
}
double dot(const double* a, const double* b, std::size_t size) {
  D2 sum{};
  for (std::size_t j = 0; j < size; j += 2) sum += load(a + j) * load(b + j);
  return sum[0] + sum[1];
}
double dot(const double* a, const double* b) {
  const D2 sum = load(a) * load(b) + load(a + 2) * load(b + 2) + load(a + 4) * load(b + 4);
  return sum[0] + sum[1];
}

// One round: minimises the augmented Lagrangian for the multipliers of the problem, or solves for Coulomb's law.
class Round {
 public:
  Round(ContactQp& qp, double penalty, int max_newton_steps)
      : qp_(qp),
        penalty_(penalty),
        max_newton_steps_(max_newton_steps),
        size_(6 + qp.group_count),
        even_((size_ + 1) / 2 * 2),
        has_law_(qp.disc_count > 0 && qp.discs[0].law > 0) {}

  /// False: it stopped before reaching the solution.
  bool solve();
  /// Stores the new multipliers. Returns the largest violation of rows and discs [mm].
  double update();

 private:
  // Derivatives of the forces of a contact, u and f, by the violation c of its row and by its tangential motion. The
  // axes of the tangents are e and t, which is e turned by 90 degrees. The sides of a contact are the gradients of c
  // and of the motions along e and t in the coordinates.
  struct Slopes {
    double press = 0;           // of u by c
    double drag = 0, lift = 0;  // of f along e by c, of u by the motion along e
    double along = 0, across = 0;
    double e[2] = {1, 0};
  };

  double off(int i) const;
  void measure();
  void disc(std::size_t k);
  [[gnu::cold]] void cone(std::size_t k);
  [[gnu::cold]] double lagrangian() const;
  void rowSlopes(std::size_t k, Slopes& s) const;
  void discSlopes(std::size_t k, Slopes& s) const;
  [[gnu::cold]] void coneSlopes(std::size_t k, Slopes& s) const;
  struct Part {
    std::size_t row, side_count;  // 1 or 3
    const FrictionDisc* disc;     // or null
    Slopes slopes;
  };
  void findParts();
  void sidesOf(const Part& part, Coordinates* side) const;
  void addPart(const Part& part, const Coordinates* side);
  bool eliminate(std::size_t size);
  void pull();
  bool newtonStep();
  double slack(std::size_t k) const;
  void normal(std::size_t k, double* n) const;
  double& coordinate(int i);
  bool holdReversed();
  bool solveLaw(double gradient_tolerance);
  [[gnu::cold]] bool descend(double gradient_tolerance);
  double residual() const;
  double residualAt(const Coordinates& from, double share);

  ContactQp& qp_;
  const double penalty_;
  const int max_newton_steps_;
  const int size_, even_;  // number of coordinates; the next even number
  const bool has_law_;
  Coordinates x_, gradient_, step_;
  double matrix_[kMaxCoordinates][kMaxCoordinates];
  std::array<Part, 2 * kMaxContactRows + 1> parts_;
  std::size_t part_count_, side_count_;
  std::array<double, kMaxContactRows> stiffness_, start_;  // of rows: slope of the multiplier, violation that gave the last one
  std::array<double, kMaxContactRows> slack_, multiplier_, pressure_, radius_;
  std::array<std::array<double, 2>, kMaxContactRows> slip_, force_, pull_;
  // For each disc: it slipped in the last iterate; it is assumed to stick in the next step.
  std::array<bool, kMaxContactRows> slid_, held_;
};

double& Round::coordinate(int i) { return i < 6 ? qp_.y[i] : qp_.given[static_cast<std::size_t>(i - 6)]; }

// In all coordinates, with a zero at the end if their number is odd.
void Round::normal(std::size_t k, double* n) const {
  const ContactRow& r = qp_.rows[k];
  for (int i = 0; i < 6; ++i) n[i] = r.a[i];
  if (size_ == 6) return;
  for (int i = 6; i < even_; ++i) n[i] = 0;
  if (r.group >= 0) n[6 + r.group] = r.give;
}

double Round::slack(std::size_t k) const {
  const ContactRow& r = qp_.rows[k];
  const double left = r.b - dot(r.a.data(), x_.data());
  return r.group < 0 ? left : left - r.give * x_[static_cast<std::size_t>(6 + r.group)];
}

void Round::rowSlopes(std::size_t k, Slopes& s) const { s.press = multiplier_[k] > 0 ? stiffness_[k] : 0; }

// The maximum, over forces f in the disc, of  f . v - |f - f_last|^2 / (2 penalty).
void Round::disc(std::size_t k) {
  const FrictionDisc& d = qp_.discs[k];
  // The force on the tool is -f.
  const double w0 = penalty_ * slip_[k][0] - d.force[0], w1 = penalty_ * slip_[k][1] - d.force[1], square = w0 * w0 + w1 * w1,
               radius = d.law > 0 ? d.law * multiplier_[static_cast<std::size_t>(d.row)] : d.radius;
  const double scale = square > kSlips * radius * radius ? radius / std::sqrt(square) : 1;
  radius_[k] = radius;
  force_[k] = {-scale * w0, -scale * w1};
}

void Round::discSlopes(std::size_t k, Slopes& s) const {
  const FrictionDisc& d = qp_.discs[k];
  if (!(radius_[k] > 0)) return;
  const double w0 = penalty_ * slip_[k][0] - d.force[0], w1 = penalty_ * slip_[k][1] - d.force[1], square = w0 * w0 + w1 * w1;
  if (!(square > kSlips * radius_[k] * radius_[k]) || held_[k]) {
    s.along = s.across = penalty_;
    return;
  }
  const double length = std::sqrt(square);  // along w the force of a slipping contact is constant
  s.e[0] = w0 / length;
  s.e[1] = w1 / length;
  s.across = penalty_ * radius_[k] / length;
  s.drag = d.law * s.press;
}

// The maximum, over (u, f) with |f| <= friction u, of  u c + f . v - |(u, f) - (u, f)_last|^2 / (2 penalty).
void Round::cone(std::size_t k) {
  const FrictionDisc& d = qp_.discs[k];
  const double mu = d.friction, c = slack_[static_cast<std::size_t>(d.row)] - mu * d.slip, w = d.pressure + penalty_ * c,
               q0 = penalty_ * slip_[k][0] - d.force[0], q1 = penalty_ * slip_[k][1] - d.force[1], length = std::sqrt(q0 * q0 + q1 * q1);
  double u = 0, scale = 0;
  if (length <= mu * w)
    u = w, scale = 1;
  else if (mu * length > -w)
    u = (w + mu * length) / (1 + mu * mu), scale = mu * u / length;
  pressure_[k] = u;
  force_[k] = {-scale * q0, -scale * q1};
}

void Round::coneSlopes(std::size_t k, Slopes& s) const {
  if (!(pressure_[k] > 0)) return;
  const FrictionDisc& d = qp_.discs[k];
  const double mu = d.friction, w = d.pressure + penalty_ * (slack_[static_cast<std::size_t>(d.row)] - mu * d.slip),
               q[2] = {penalty_ * slip_[k][0] - d.force[0], penalty_ * slip_[k][1] - d.force[1]},
               length = std::sqrt(q[0] * q[0] + q[1] * q[1]);
  if (length <= mu * w) {
    s.press = s.along = s.across = penalty_;
    return;
  }
  s.press = penalty_ / (1 + mu * mu);
  s.drag = s.lift = mu * s.press;
  s.along = mu * s.drag;
  s.across = penalty_ * mu * pressure_[k] / length;
  s.e[0] = q[0] / length;
  s.e[1] = q[1] / length;
}

// Difference of a coordinate from its value at rest.
double Round::off(int i) const {
  const auto at = static_cast<std::size_t>(i);
  return x_[at] - (i < 6 ? qp_.target[i] : qp_.rest[at - 6]);
}

// Computes multipliers and forces at x_.
void Round::measure() {
  held_.fill(false);
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.row_count); ++k) {
    // The maximum, over multipliers u >= 0, of  u c - compliance u^2 / 2 - (u - u_last)^2 / (2 penalty).
    slack_[k] = slack(k);
    multiplier_[k] = std::max(0.0, (start_[k] + slack_[k]) * stiffness_[k]);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.disc_count); ++k) {
    const FrictionDisc& d = qp_.discs[k];
    for (std::size_t i = 0; i < 2; ++i) slip_[k][i] = dot(d.across[i].data(), x_.data()) - d.origin[i];
    d.friction > 0 ? cone(k) : disc(k);
  }
}

// After measure(): the value of the augmented Lagrangian, with the maxima that measure(), disc() and cone() found.
double Round::lagrangian() const {
  double value = 0;
  for (int i = 0; i < size_; ++i) value += 0.5 * off(i) * off(i);
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.row_count); ++k) {
    const ContactRow& r = qp_.rows[k];
    const double u = multiplier_[k], change = u - r.multiplier;
    value += u * slack_[k] - 0.5 * r.compliance * u * u - change * change / (2 * penalty_);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.disc_count); ++k) {
    const FrictionDisc& d = qp_.discs[k];
    const double c0 = d.force[0] - force_[k][0], c1 = d.force[1] - force_[k][1];
    double change2 = c0 * c0 + c1 * c1;
    if (d.friction > 0) {
      value += pressure_[k] * (slack_[static_cast<std::size_t>(d.row)] - d.friction * d.slip);
      change2 += (pressure_[k] - d.pressure) * (pressure_[k] - d.pressure);
    }
    value -= force_[k][0] * slip_[k][0] + force_[k][1] * slip_[k][1] + change2 / (2 * penalty_);
  }
  return value;
}

// After measure(): computes the gradient.
void Round::pull() {
  for (std::size_t i = 0; i < 6; i += 2) store(&gradient_[i], load(&x_[i]) - load(qp_.target.data() + i));
  for (int i = 6; i < even_; ++i) gradient_[static_cast<std::size_t>(i)] = i < size_ ? off(i) : 0;
  const auto along = [&](double force, const double* a) { addTimes(gradient_.data(), force, a); };
  const auto press = [&](double force, std::size_t k) {
    if (!(force > 0)) return;
    along(-force, qp_.rows[k].a.data());
    if (size_ == 6) return;
    Coordinates n;
    normal(k, n.data());
    for (std::size_t i = 6; i < static_cast<std::size_t>(size_); ++i) gradient_[i] -= force * n[i];
  };
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.row_count); ++k) press(multiplier_[k], k);
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.disc_count); ++k) {
    const FrictionDisc& d = qp_.discs[k];
    if (d.friction > 0) press(pressure_[k], static_cast<std::size_t>(d.row));
    for (std::size_t i = 0; i < 2; ++i) along(-force_[k][i], d.across[i].data());
  }
}

// Lists the contacts that exert forces, with their slopes.
void Round::findParts() {
  part_count_ = side_count_ = 0;
  bool is_joined[kMaxContactRows] = {};
  const auto take = [&](std::size_t row, const FrictionDisc* disc) {
    Part& part = parts_[part_count_];
    if (!(part.slopes.press + part.slopes.along + part.slopes.across > 0)) return;
    ++part_count_;
    part.row = row;
    part.disc = disc;
    part.side_count = disc ? 3 : 1;
    side_count_ += part.side_count;
  };
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.disc_count); ++k) {
    const FrictionDisc& d = qp_.discs[k];
    const auto row = d.law > 0 || d.friction > 0 ? static_cast<std::size_t>(d.row) : 0;  // a disc alone has none
    Slopes& slopes = parts_[part_count_].slopes;
    slopes = {};
    if (d.friction > 0) {
      coneSlopes(k, slopes);
    } else {
      if (d.law > 0) {
        is_joined[row] = true;
        rowSlopes(row, slopes);
      }
      discSlopes(k, slopes);
    }
    take(row, &d);
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.row_count); ++k) {
    if (is_joined[k]) continue;
    parts_[part_count_].slopes = {};
    rowSlopes(k, parts_[part_count_].slopes);
    take(k, nullptr);
  }
}

// The sides of a part. The violation decreases along the normal.
void Round::sidesOf(const Part& part, Coordinates* side) const {
  normal(part.row, side[0].data());
  for (std::size_t i = 0; i < static_cast<std::size_t>(even_); i += 2) store(&side[0][i], -load(&side[0][i]));
  if (!part.disc) return;
  const double *const e = part.slopes.e, *const a0 = part.disc->across[0].data(), *const a1 = part.disc->across[1].data();
  for (std::size_t i = 0; i < 6; i += 2) {
    store(&side[1][i], splat(e[0]) * load(a0 + i) + splat(e[1]) * load(a1 + i));
    store(&side[2][i], splat(e[0]) * load(a1 + i) - splat(e[1]) * load(a0 + i));
  }
  for (std::size_t m = 1; m < 3; ++m)
    for (int i = 6; i < even_; ++i) side[m][static_cast<std::size_t>(i)] = 0;
}

// Solves matrix_ x = step_ for step_ by Gaussian elimination: for Coulomb's law the matrix is not symmetric.
bool Round::eliminate(std::size_t size) {
  double* row[kMaxCoordinates];
  for (std::size_t i = 0; i < size; ++i) row[i] = matrix_[i];
  for (std::size_t k = 0; k < size; ++k) {
    std::size_t pivot = k;
    for (std::size_t i = k + 1; i < size; ++i)
      if (__builtin_fabs(row[i][k]) > __builtin_fabs(row[pivot][k])) pivot = i;
    if (!(__builtin_fabs(row[pivot][k]) > 0)) return false;
    std::swap(row[k], row[pivot]);
    std::swap(step_[k], step_[pivot]);
    const double inverse = 1 / row[k][k];
    const std::size_t from = k & ~std::size_t{1};
    for (std::size_t i = k + 1; i < size; ++i) {
      const double share = -row[i][k] * inverse;
      addTimes(row[i] + from, share, row[k] + from, size - from);
      step_[i] += share * step_[k];
    }
  }
  for (std::size_t i = size; i-- > 0;) {
    double sum = step_[i];
    for (std::size_t k = i + 1; k < size; ++k) sum -= row[i][k] * step_[k];
    step_[i] = sum / row[i][i];
  }
  return true;
}

// Adds to the matrix what a part contributes: a sum of products of a column and a row.
void Round::addPart(const Part& part, const Coordinates* side) {
  const auto even = static_cast<std::size_t>(even_);
  const Slopes& s = part.slopes;
  Coordinates column[3];
  const double* row[3];
  std::size_t count = 0;
  const auto add = [&](double by_normal, double by_e, const Coordinates& of) {
    for (std::size_t j = 0; j < even; j += 2) {
      D2 sum = splat(by_normal) * load(&side[0][j]);
      if (by_e != 0) sum += splat(by_e) * load(&side[1][j]);
      store(&column[count][j], sum);
    }
    row[count++] = of.data();
  };
  add(s.press, s.drag, side[0]);
  if (s.along > 0) add(s.lift, s.along, side[1]);
  if (s.across > 0) {
    for (std::size_t j = 0; j < even; j += 2) store(&column[count][j], splat(s.across) * load(&side[2][j]));
    row[count++] = side[2].data();
  }
  for (std::size_t i = 0; i < even; ++i)
    for (std::size_t n = 0; n < count; ++n) {
      addTimes(matrix_[i], column[n][i], row[n]);
      if (even > 6) addTimes(matrix_[i] + 6, column[n][i], row[n] + 6, even - 6);
    }
}

// With the sides S of all parts and their slopes M, the derivative of the gradient is I + S^T M S. It is solved as it
// is or, if there are few sides, by means of the smaller matrix I + M S S^T (M. Woodbury 1950).
bool Round::newtonStep() {
  findParts();
  const auto even = static_cast<std::size_t>(even_), size = static_cast<std::size_t>(size_);
  const bool is_small = has_law_ && side_count_ <= kSmallSystem;  // the other is more accurate
  Coordinates side[kSmallSystem];
  if (!is_small)
    for (std::size_t i = 0; i < size; ++i) {
      for (std::size_t j = 0; j < even; j += 2) store(matrix_[i] + j, D2{});
      matrix_[i][i] = 1;
      step_[i] = -gradient_[i];
    }
  for (std::size_t p = 0, at = 0; p < part_count_; ++p) {
    const Part& part = parts_[p];
    Coordinates* const own = side + (is_small ? at : 0);
    sidesOf(part, own);
    at += part.side_count;
    if (is_small) continue;
    addPart(part, own);
  }
  if (!is_small) return eliminate(size);
  double product[kSmallSystem][kSmallSystem + 1] = {}, fall[kSmallSystem];
  for (std::size_t i = 0; i < side_count_; ++i) {
    for (std::size_t j = 0; j <= i; ++j) product[i][j] = product[j][i] = dot(side[i].data(), side[j].data(), even);
    fall[i] = dot(side[i].data(), gradient_.data(), even);
  }
  for (std::size_t p = 0, at = 0; p < part_count_; at += parts_[p++].side_count)
    for (std::size_t m = 0; m < parts_[p].side_count; ++m) {
      const Slopes& s = parts_[p].slopes;
      const double slope[3][3] = {{s.press, s.lift, 0}, {s.drag, s.along, 0}, {0, 0, s.across}};
      double* const row = matrix_[at + m];
      std::memset(row, 0, (kSmallSystem + 1) * sizeof(double));
      row[at + m] = 1;
      step_[at + m] = 0;
      for (std::size_t n = 0; n < parts_[p].side_count; ++n) {
        addTimes(row, slope[m][n], product[at + n], kSmallSystem + 1);
        step_[at + m] -= slope[m][n] * fall[at + n];
      }
    }
  if (!eliminate(side_count_)) return false;
  double force[kSmallSystem];
  std::memcpy(force, step_.data(), sizeof force);
  for (std::size_t i = 0; i < even; ++i) step_[i] = -gradient_[i];
  for (std::size_t i = 0; i < side_count_; ++i) addTimes(step_.data(), -force[i], side[i].data(), even);
  return true;
}

double Round::residual() const { return dot(gradient_.data(), gradient_.data(), static_cast<std::size_t>(even_)); }

// Newton's method on the residual. After some whole steps, a step that increases the residual is shortened. False: no
// convergence.
bool Round::solveLaw(double gradient_tolerance) {
  slid_.fill(false);
  measure();
  pull();
  double left = residual();
  for (int n = 0; left > gradient_tolerance * gradient_tolerance; ++n) {
    if (qp_.iterations >= max_newton_steps_) return false;
    if (holdReversed()) pull();
    if (!newtonStep()) return false;
    ++qp_.iterations;
    const Coordinates from = x_;
    const double before = left;
    left = residualAt(from, 1);
    if (n < kWholeSteps || left <= before) continue;
    double best = 1;
    for (const double share : kShorterParts)
      if (const double next = residualAt(from, share); next < left) left = next, best = share;
    if (best != kShorterParts.back()) residualAt(from, best);
  }
  return true;
}

double Round::residualAt(const Coordinates& from, double share) {
  for (std::size_t i = 0; i < static_cast<std::size_t>(size_); ++i) x_[i] = from[i] + share * step_[i];
  measure();
  pull();
  return residual();
}

// A slipping contact whose slip reverses in an iterate is assumed to stick in the next one; from there it may slip in
// another direction. Returns whether there is one.
bool Round::holdReversed() {
  bool any = false;
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.disc_count); ++k) {
    const FrictionDisc& d = qp_.discs[k];
    const double w0 = penalty_ * slip_[k][0] - d.force[0], w1 = penalty_ * slip_[k][1] - d.force[1];
    const bool slides = w0 * w0 + w1 * w1 > kSlips * radius_[k] * radius_[k];
    held_[k] = slides && slid_[k] && radius_[k] > 0 && w0 * pull_[k][0] + w1 * pull_[k][1] < 0;
    slid_[k] = slides && !held_[k] && radius_[k] > 0;
    pull_[k] = {w0, w1};
    if (!held_[k]) continue;
    any = true;
    force_[k] = {-w0, -w1};
  }
  return any;
}

bool Round::descend(double gradient_tolerance) {
  measure();
  double value = lagrangian();
  for (;;) {
    pull();
    if (residual() <= gradient_tolerance * gradient_tolerance) return true;
    if (qp_.iterations >= max_newton_steps_ || !newtonStep()) return false;
    ++qp_.iterations;
    double slope = 0, part = 1, next = value;
    for (int i = 0; i < size_; ++i) slope += gradient_[static_cast<std::size_t>(i)] * step_[static_cast<std::size_t>(i)];
    const Coordinates from = x_;
    for (int n = 0; n < kMaxShorterSteps; ++n, part /= 2) {
      for (int i = 0; i < size_; ++i)
        x_[static_cast<std::size_t>(i)] = from[static_cast<std::size_t>(i)] + part * step_[static_cast<std::size_t>(i)];
      measure();
      next = lagrangian();
      if (next <= value + 1e-4 * part * slope + 1e-15 * (1 + std::abs(value))) break;
    }
    if (!(next < value) && -slope < 1e-14 * (1 + std::abs(value))) return true;  // only rounding is left
    value = next;
  }
}

bool Round::solve() {
  for (int i = 0; i < size_; ++i) x_[static_cast<std::size_t>(i)] = coordinate(i);
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.row_count); ++k) {
    stiffness_[k] = penalty_ / (1 + penalty_ * qp_.rows[k].compliance);
    start_[k] = qp_.rows[k].multiplier / penalty_;
  }
  const double gradient_tolerance = (has_law_ ? qp_.tolerance : 1e-10) * (1 + qp_.target.norm());
  const bool is_minimum = has_law_ ? solveLaw(gradient_tolerance) : descend(gradient_tolerance);
  for (int i = 0; i < size_; ++i) coordinate(i) = x_[static_cast<std::size_t>(i)];
  return is_minimum;
}

double Round::update() {
  double left = 0;
  const auto take = [&](double& last, double now) {
    left = std::max(left, std::abs(now - last) / penalty_);
    last = now;
  };
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.row_count); ++k) take(qp_.rows[k].multiplier, multiplier_[k]);
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.disc_count); ++k) {
    if (qp_.discs[k].friction > 0) take(qp_.discs[k].pressure, pressure_[k]);
    for (std::size_t i = 0; i < 2; ++i) take(qp_.discs[k].force[i], force_[k][i]);
  }
  return left;
}

}  // namespace

void solveContactQp(ContactQp& qp) noexcept {
  qp.iterations = 0;
  qp.converged = false;
  const bool has_law = qp.disc_count > 0 && qp.discs[0].law > 0;
  const auto rounds = [&qp](double penalty, int max_newton_steps) {
    for (int n = 0; n < kMaxMultiplierRounds && !qp.converged && qp.iterations < max_newton_steps; ++n) {
      Round round(qp, penalty, max_newton_steps);
      const Vector6 before = qp.y;
      const bool is_minimum = round.solve();
      qp.converged = round.update() <= qp.tolerance && (qp.disc_count > 0 ? is_minimum : (qp.y - before).norm() <= qp.tolerance);
      penalty = std::min(kMaxPenalty, kPenaltyGrowth * penalty);
    }
  };
  double guess = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k) guess += qp.rows[k].multiplier;
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp.disc_count); ++k) guess += qp.discs[k].pressure;
  if (guess > 0 || has_law) rounds(has_law ? kLawPenalty : kWarmPenalty, kWarmNewtonSteps);
  if (!has_law) rounds(kMinPenalty, kMaxNewtonSteps);
}

}  // namespace spheretree::runtime
