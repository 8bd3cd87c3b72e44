// SPDX-License-Identifier: Apache-2.0
#include "contact/proximal_point.h"

#include <algorithm>
#include <cmath>

namespace spheretree::runtime {
namespace {

constexpr double kScale = 3e-5;  // of a force against its motion, in a round
constexpr int kMaxRounds = 12, kMaxNewtonSteps = 48;

// A round minimises  z G z / 2 + sum of scale (y f - f f / 2)  over all z, with the motions w = q + G z,
// y = center - w / scale and f the nearest allowed force to y. Its gradient is G (z - f); f is the next center.
class Round {
 public:
  explicit Round(ContactSystem& of) : of_(of) { std::copy_n(of.p.begin(), of.count, center_.begin()); }

  /// Leaves f in the forces.
  void minimise();

 private:
  double value(const ContactSystem::Vector& z);
  bool newtonStep(const ContactSystem::Vector& z);

  ContactSystem& of_;
  ContactSystem::Vector center_, force_, motion_;  // center, f, w
};

double Round::value(const ContactSystem::Vector& z) {
  std::copy_n(z.begin(), of_.count, of_.p.begin());
  of_.findMotions();
  double sum = 0;
  for (std::size_t i = 0; i < of_.count; ++i) sum += 0.5 * z[i] * (of_.w[i] - of_.q[i]);
  for (std::size_t k = 0; k < of_.part_count; ++k) {
    const ContactPart& part = of_.parts[k];
    double y[3], f[3];
    for (std::size_t a = 0; a < part.size; ++a) f[a] = y[a] = center_[part.at[a]] - of_.w[part.at[a]] / kScale;
    of_.nearest(part, f, nullptr);
    for (std::size_t a = 0; a < part.size; ++a) {
      force_[part.at[a]] = f[a];
      sum += kScale * f[a] * (y[a] - 0.5 * f[a]);
    }
  }
  return sum;
}

// z + step = f + the change of f with G step, linearised; the step is in right_. Parts that exert nothing come to 0.
bool Round::newtonStep(const ContactSystem::Vector& z) {
  of_.unknown_count = 0;
  for (std::size_t i = 0; i < of_.count; ++i) of_.unknown[of_.unknown_count++] = i;
  for (std::size_t k = 0; k < of_.part_count; ++k) {
    const ContactPart& part = of_.parts[k];
    Slopes slopes;
    double y[3];
    for (std::size_t a = 0; a < part.size; ++a) y[a] = center_[part.at[a]] - of_.w[part.at[a]] / kScale;
    of_.nearest(part, y, &slopes);
    for (std::size_t a = 0; a < part.size; ++a) {
      const std::size_t i = part.at[a];
      ContactSystem::Vector& equation = of_.matrix[i];
      std::fill_n(equation.begin(), of_.count, 0.0);
      equation[i] = 1;
      for (std::size_t b = 0; b < part.size; ++b)
        for (std::size_t j = 0; slopes.by[a][b] != 0 && j < of_.count; ++j) equation[j] += slopes.by[a][b] / kScale * of_.g[part.at[b]][j];
      of_.right[i] = y[a] - z[i];
    }
  }
  of_.products += 3.0 * static_cast<double>(of_.count * of_.count);
  return of_.solveEquations();
}

void Round::minimise() {
  const double tolerance = kSolved * of_.problem.tolerance;
  ContactSystem::Vector z = center_;
  double now = value(z);
  for (int n = 0;; ++n) {
    std::copy_n(of_.w.begin(), of_.count, motion_.begin());
    of_.p = force_;
    of_.findMotions();  // of f
    double largest = 0;
    ContactSystem::Vector gradient;
    for (std::size_t i = 0; i < of_.count; ++i) {
      gradient[i] = motion_[i] - of_.w[i];
      largest = std::max(largest, std::abs(gradient[i]));
    }
    if (largest <= tolerance) return;
    of_.w = motion_;
    if (n == kMaxNewtonSteps || of_.isSpent() || !newtonStep(z)) return;
    ++of_.iterations;
    double slope = 0;
    for (std::size_t i = 0; i < of_.count; ++i) slope += gradient[i] * of_.right[i];
    if (-slope < 1e-14 * (1 + std::abs(now))) return;  // only rounding is left
    const ContactSystem::Vector step = of_.right;
    double share = 1, next = now;
    for (;; share /= 2) {
      ContactSystem::Vector there;
      for (std::size_t i = 0; i < of_.count; ++i) there[i] = z[i] + share * step[i];
      next = value(there);
      if (next <= now + 1e-4 * share * slope + 1e-15 * (1 + std::abs(now)) || share < 1e-6) {
        z = there;
        break;
      }
    }
    now = next;
  }
}

}  // namespace

void approachMinimum(ContactSystem& system) noexcept {
  const double tolerance = system.problem.tolerance;
  system.allow();
  double left = system.residual();
  for (int n = 0; n < kMaxRounds && !(left <= kSolved * tolerance) && !system.isSpent(); ++n) {
    const double before = left;
    Round(system).minimise();
    left = system.residual();
    if (left <= tolerance && left > 0.5 * before) break;  // rounding
  }
}

}  // namespace spheretree::runtime
