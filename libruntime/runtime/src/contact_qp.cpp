// SPDX-License-Identifier: Apache-2.0
#include "contact_qp.h"

#include <algorithm>
#include <cmath>

namespace spheretree::runtime {
namespace {

constexpr int kMostCoordinates = 6 + kMostGroups + kMostContactRows;
// Penalties of the augmented Lagrangian, round by round [1]. With nearly correct multipliers a large penalty is best;
// otherwise the inner problem is smoother with a small one.
constexpr double kWarmPenalty = 1e5, kLeastPenalty = 30, kPenaltyGrowth = 10, kMostPenalty = 1e6;
constexpr int kWarmNewtonSteps = 25;       // if these do not suffice, the initial multipliers were no good guess
constexpr int kMostMultiplierRounds = 20;  // rounds of multiplier updates
constexpr int kMostNewtonSteps = 200;      // over all rounds
constexpr int kMostShorterSteps = 30;

using Coordinates = std::array<double, kMostCoordinates>;

// One round: minimises the augmented Lagrangian for the multipliers of the problem.
class Round {
 public:
  Round(ContactQp& qp, double penalty, int most_newton_steps)
      : qp_(qp),
        penalty_(penalty),
        most_newton_steps_(most_newton_steps),
        tissue_(6 + qp.group_count),
        size_(6 + qp.group_count + qp.tissue_count),
        has_law_(qp.disc_count > 0 && qp.discs[0].law > 0) {}

  /// False: it stopped before reaching the minimum.
  bool solve();
  /// Stores the new multipliers. Returns the largest violation of rows and discs [mm].
  double update();

 private:
  double evaluate(const Coordinates& x, bool with_derivatives);
  double row(const ContactRow& r, int k, const Coordinates& x, bool with_derivatives);
  double disc(const FrictionDisc& d, int k, const Coordinates& x, bool with_derivatives);
  double cone(const FrictionDisc& d, int k, const Coordinates& x, bool with_derivatives);
  Coordinates normal(int k) const;
  bool newtonStep(Coordinates& step) const;
  double slack(const ContactRow& r, int k, const Coordinates& x) const;
  double& coordinate(int i);

  ContactQp& qp_;
  const double penalty_;
  const int most_newton_steps_;
  const int tissue_, size_;  // index of the first tissue coordinate; number of all coordinates
  const bool has_law_;
  Coordinates gradient_;
  double hessian_[kMostCoordinates][kMostCoordinates];
  std::array<double, kMostContactRows> multiplier_, pressure_, radius_;
  std::array<std::array<double, 2>, kMostContactRows> force_;
};

double dot(const Vector6& a, const Coordinates& x) {
  double sum = 0;
  for (int k = 0; k < 6; ++k) sum += a[k] * x[static_cast<std::size_t>(k)];
  return sum;
}

double Round::slack(const ContactRow& r, int k, const Coordinates& x) const {
  double left = r.b - dot(r.a, x) - (r.group < 0 ? 0 : r.give * x[static_cast<std::size_t>(6 + r.group)]);
  for (int i = tissue_; i < size_; ++i)
    left -= qp_.tissue[static_cast<std::size_t>(k)][static_cast<std::size_t>(i - tissue_)] * x[static_cast<std::size_t>(i)];
  return left;
}

double& Round::coordinate(int i) {
  if (i < 6) return qp_.y[i];
  return i < tissue_ ? qp_.given[static_cast<std::size_t>(i - 6)] : qp_.tissue_given[static_cast<std::size_t>(i - tissue_)];
}

Coordinates Round::normal(int k) const {
  const ContactRow& r = qp_.rows[static_cast<std::size_t>(k)];
  Coordinates n{};
  for (int i = 0; i < 6; ++i) n[static_cast<std::size_t>(i)] = r.a[i];
  if (r.group >= 0) n[static_cast<std::size_t>(6 + r.group)] = r.give;
  for (int i = tissue_; i < size_; ++i)
    n[static_cast<std::size_t>(i)] = qp_.tissue[static_cast<std::size_t>(k)][static_cast<std::size_t>(i - tissue_)];
  return n;
}

// The maximum, over multipliers u >= 0, of  u c - compliance u^2 / 2 - (u - u_last)^2 / (2 penalty).
double Round::row(const ContactRow& r, int k, const Coordinates& x, bool with_derivatives) {
  const double c = slack(r, k, x), stiffness = penalty_ / (1 + penalty_ * r.compliance);
  const double u = std::max(0.0, (r.multiplier / penalty_ + c) * stiffness), change = u - r.multiplier;
  multiplier_[static_cast<std::size_t>(k)] = u;
  if (with_derivatives && u > 0) {
    const Coordinates n = normal(k);
    for (int i = 0; i < size_; ++i) {
      const double ni = n[static_cast<std::size_t>(i)];
      gradient_[static_cast<std::size_t>(i)] -= u * ni;
      for (int j = 0; j <= i; ++j) hessian_[i][j] += stiffness * ni * n[static_cast<std::size_t>(j)];
    }
  }
  return u * c - 0.5 * r.compliance * u * u - change * change / (2 * penalty_);
}

// The maximum, over forces f in the disc, of  f . v - |f - f_last|^2 / (2 penalty).
double Round::disc(const FrictionDisc& d, int k, const Coordinates& x, bool with_derivatives) {
  const double v[2] = {dot(d.across[0], x) - d.origin[0], dot(d.across[1], x) - d.origin[1]};
  // The force on the tool is -f.
  const double w[2] = {penalty_ * v[0] - d.force[0], penalty_ * v[1] - d.force[1]}, length = std::sqrt(w[0] * w[0] + w[1] * w[1]);
  double& radius = radius_[static_cast<std::size_t>(k)];
  if (!has_law_) radius = d.radius;
  if (has_law_ && with_derivatives) radius = d.law * multiplier_[static_cast<std::size_t>(d.row)];
  const bool slips = length > radius;
  const double scale = slips ? radius / length : 1, f[2] = {scale * w[0], scale * w[1]};
  force_[static_cast<std::size_t>(k)] = {-f[0], -f[1]};
  if (with_derivatives) {
    const double across = slips ? 1 / (length * length) : 0;  // along w the force of a slipping contact is constant
    const double s = penalty_ * scale, h00 = s * (1 - across * w[0] * w[0]), h01 = -s * across * w[0] * w[1],
                 h11 = s * (1 - across * w[1] * w[1]);
    for (int i = 0; i < 6; ++i) {
      const double a = d.across[0][i], b = d.across[1][i];
      gradient_[static_cast<std::size_t>(i)] += f[0] * a + f[1] * b;
      for (int j = 0; j <= i; ++j)
        hessian_[i][j] += a * (h00 * d.across[0][j] + h01 * d.across[1][j]) + b * (h01 * d.across[0][j] + h11 * d.across[1][j]);
    }
  }
  const double c0 = f[0] + d.force[0], c1 = f[1] + d.force[1];
  return f[0] * v[0] + f[1] * v[1] - (c0 * c0 + c1 * c1) / (2 * penalty_);
}

// The maximum, over (u, f) with |f| <= friction u, of  u c + f . v - |(u, f) - (u, f)_last|^2 / (2 penalty).
double Round::cone(const FrictionDisc& d, int k, const Coordinates& x, bool with_derivatives) {
  const auto at = static_cast<std::size_t>(k);
  const double mu = d.friction, c = slack(qp_.rows[static_cast<std::size_t>(d.row)], d.row, x) - mu * d.slip,
               v[2] = {dot(d.across[0], x) - d.origin[0], dot(d.across[1], x) - d.origin[1]};
  const double w = d.pressure + penalty_ * c, q[2] = {penalty_ * v[0] - d.force[0], penalty_ * v[1] - d.force[1]},
               length = std::sqrt(q[0] * q[0] + q[1] * q[1]);
  double u = 0, f[2] = {0, 0};
  double d00 = 0, d0[2] = {0, 0}, d11[3] = {0, 0, 0};  // derivatives of (u, f) by (w, q); the last one: 00, 01, 11
  if (length <= mu * w) {
    u = w, f[0] = q[0], f[1] = q[1];
    d00 = d11[0] = d11[2] = 1;
  } else if (mu * length > -w) {
    const double part = 1 / (1 + mu * mu), e[2] = {q[0] / length, q[1] / length};
    u = part * (w + mu * length);
    d00 = part;
    const double side = mu * u / length, along = part * mu * mu - side;
    for (std::size_t i = 0; i < 2; ++i) {
      f[i] = mu * u * e[i];
      d0[i] = part * mu * e[i];
    }
    d11[0] = side + along * e[0] * e[0], d11[1] = along * e[0] * e[1], d11[2] = side + along * e[1] * e[1];
  }
  pressure_[at] = u;
  force_[at] = {-f[0], -f[1]};
  if (with_derivatives && u > 0) {
    const Coordinates n = normal(d.row);
    const auto t = [&](std::size_t axis, int i) { return i < 6 ? d.across[axis][i] : 0.0; };
    for (int i = 0; i < size_; ++i) {
      const double ni = -n[static_cast<std::size_t>(i)], t0 = t(0, i), t1 = t(1, i);
      gradient_[static_cast<std::size_t>(i)] += u * ni + f[0] * t0 + f[1] * t1;
      const double by_n = d00 * ni + d0[0] * t0 + d0[1] * t1, by_0 = d0[0] * ni + d11[0] * t0 + d11[1] * t1,
                   by_1 = d0[1] * ni + d11[1] * t0 + d11[2] * t1;
      for (int j = 0; j <= i; ++j) hessian_[i][j] += penalty_ * (by_0 * t(0, j) + by_1 * t(1, j) - by_n * n[static_cast<std::size_t>(j)]);
    }
  }
  const double cu = u - d.pressure, c0 = f[0] + d.force[0], c1 = f[1] + d.force[1];
  return u * c + f[0] * v[0] + f[1] * v[1] - (cu * cu + c0 * c0 + c1 * c1) / (2 * penalty_);
}

double Round::evaluate(const Coordinates& x, bool with_derivatives) {
  double value = 0;
  for (int i = 0; i < size_; ++i) {
    const double rest = i < 6         ? qp_.target[i]
                        : i < tissue_ ? qp_.rest[static_cast<std::size_t>(i - 6)]
                                      : 0,
                 off = x[static_cast<std::size_t>(i)] - rest;
    value += 0.5 * off * off;
    if (!with_derivatives) continue;
    gradient_[static_cast<std::size_t>(i)] = off;
    for (int j = 0; j <= i; ++j) hessian_[i][j] = i == j;
  }
  for (int k = 0; k < qp_.row_count; ++k) value += row(qp_.rows[static_cast<std::size_t>(k)], k, x, with_derivatives);
  for (int k = 0; k < qp_.disc_count; ++k) {
    const FrictionDisc& d = qp_.discs[static_cast<std::size_t>(k)];
    value += d.friction > 0 ? cone(d, k, x, with_derivatives) : disc(d, k, x, with_derivatives);
  }
  return value;
}

// By Cholesky factorisation; the matrix is the identity plus a positive semidefinite matrix.
bool Round::newtonStep(Coordinates& step) const {
  double l[kMostCoordinates][kMostCoordinates];
  for (int i = 0; i < size_; ++i) {
    double b = -gradient_[static_cast<std::size_t>(i)];
    for (int j = 0; j <= i; ++j) {
      double sum = hessian_[i][j];
      for (int k = 0; k < j; ++k) sum -= l[i][k] * l[j][k];
      if (i == j && !(sum > 0)) return false;
      l[i][j] = i == j ? std::sqrt(sum) : sum / l[j][j];
      if (j < i) b -= l[i][j] * step[static_cast<std::size_t>(j)];
    }
    step[static_cast<std::size_t>(i)] = b / l[i][i];
  }
  for (int i = size_ - 1; i >= 0; --i) {
    double sum = step[static_cast<std::size_t>(i)];
    for (int k = i + 1; k < size_; ++k) sum -= l[k][i] * step[static_cast<std::size_t>(k)];
    step[static_cast<std::size_t>(i)] = sum / l[i][i];
  }
  return true;
}

bool Round::solve() {
  Coordinates x, step;
  for (int i = 0; i < size_; ++i) x[static_cast<std::size_t>(i)] = coordinate(i);
  double value = evaluate(x, true);
  const double gradient_tolerance = (has_law_ ? 0.1 * qp_.tolerance : 1e-10) * (1 + qp_.target.norm());
  bool is_least = false;
  for (;;) {
    double square = 0, slope = 0;
    for (int i = 0; i < size_; ++i) square += gradient_[static_cast<std::size_t>(i)] * gradient_[static_cast<std::size_t>(i)];
    is_least = square <= gradient_tolerance * gradient_tolerance;
    if (is_least || qp_.iterations >= most_newton_steps_ || !newtonStep(step)) break;
    ++qp_.iterations;
    for (int i = 0; i < size_; ++i) slope += gradient_[static_cast<std::size_t>(i)] * step[static_cast<std::size_t>(i)];
    const Coordinates from = x;
    double part = 1, next = value;
    for (int n = 0; n < kMostShorterSteps; ++n, part /= 2) {
      for (int i = 0; i < size_; ++i)
        x[static_cast<std::size_t>(i)] = from[static_cast<std::size_t>(i)] + part * step[static_cast<std::size_t>(i)];
      next = evaluate(x, n == 0 && !has_law_);  // the whole step is usually accepted
      if (next <= value + 1e-4 * part * slope + 1e-15 * std::abs(value)) break;
    }
    const bool is_rounding = !(next < value) && -slope < 1e-14 * (1 + std::abs(value));
    value = part < 1 || has_law_ ? evaluate(x, true) : next;
    if (is_rounding) {
      is_least = !has_law_;
      break;
    }
  }
  for (int i = 0; i < size_; ++i) coordinate(i) = x[static_cast<std::size_t>(i)];
  return is_least;
}

double Round::update() {
  double left = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.row_count); ++k) {
    left = std::max(left, std::abs(multiplier_[k] - qp_.rows[k].multiplier) / penalty_);
    qp_.rows[k].multiplier = multiplier_[k];
  }
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp_.disc_count); ++k) {
    if (qp_.discs[k].friction > 0) {
      left = std::max(left, std::abs(pressure_[k] - qp_.discs[k].pressure) / penalty_);
      qp_.discs[k].pressure = pressure_[k];
    }
    for (std::size_t i = 0; i < 2; ++i) {
      left = std::max(left, std::abs(force_[k][i] - qp_.discs[k].force[i]) / penalty_);
      qp_.discs[k].force[i] = force_[k][i];
    }
  }
  return left;
}

}  // namespace

void solveContactQp(ContactQp& qp) noexcept {
  qp.iterations = 0;
  qp.converged = false;
  const auto rounds = [&qp](double penalty, int most_newton_steps) {
    for (int n = 0; n < kMostMultiplierRounds && !qp.converged && qp.iterations < most_newton_steps; ++n) {
      Round round(qp, penalty, most_newton_steps);
      const Vector6 before = qp.y;
      const bool is_least = round.solve();
      qp.converged = round.update() <= qp.tolerance && (qp.disc_count > 0 ? is_least : (qp.y - before).norm() <= qp.tolerance);
      penalty = std::min(kMostPenalty, kPenaltyGrowth * penalty);
    }
  };
  double guess = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp.row_count); ++k) guess += qp.rows[k].multiplier;
  for (std::size_t k = 0; k < static_cast<std::size_t>(qp.disc_count); ++k) guess += qp.discs[k].pressure;
  const bool has_law = qp.disc_count > 0 && qp.discs[0].law > 0;
  if (guess > 0 || has_law) rounds(kWarmPenalty, kWarmNewtonSteps);
  if (!has_law) rounds(kLeastPenalty, kMostNewtonSteps);
}

}  // namespace spheretree::runtime
