// SPDX-License-Identifier: Apache-2.0
#include "contact/contact_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/contact_system.h"
#include "contact/proximal_point.h"

namespace spheretree::runtime {
namespace {

constexpr double kProductsPerWork = 8;  // of a unit of work
constexpr double kSolveWork = 20;       // of a call
constexpr double kDamping = 1e-4;       // of the diagonal, in a Newton step: contacts side by side have nearly the same equations
// Whole Newton steps; sweeps that start them anew, twice as many each time; and how often. What that does not solve
// would come too late for the hand.
constexpr int kNewtonSteps = 8, kSweeps = 20, kStarts = 6;

// Each part in turn the nearest allowed force to that of a step against its motion; of a contact first the normal
// force, on which the disc depends.
void sweep(ContactSystem& s) {
  double z[3];
  for (std::size_t k = 0; k < s.part_count; ++k) {
    const ContactPart& part = s.parts[k];
    std::size_t a = 0;
    if (part.size == 3) {
      const std::size_t row = part.at[a++];
      s.change(row, std::max(-s.p[row], -s.w[row] / part.scale[0]));
    }
    s.aim(part, z);
    s.nearest(part, z, nullptr);
    for (; a < part.size; ++a) s.change(part.at[a], z[a] - s.p[part.at[a]]);
  }
  s.products += static_cast<double>(s.count * s.count);
}

// force = nearest(force - motion / scale), linearised, for the forces of a part, which are unknowns from `at` on.
void addEquations(ContactSystem& s, const ContactPart& part, std::size_t at) {
  Slopes slopes;
  double z[3];
  s.aim(part, z);
  s.nearest(part, z, &slopes);
  for (std::size_t a = 0; a < part.size; ++a) {
    ContactSystem::Vector& equation = s.matrix[at + a];
    const double scale = part.scale[a];
    std::fill_n(equation.begin(), s.unknown_count, 0.0);
    for (std::size_t b = 0; b < part.size; ++b) {
      const double slope = slopes.by[a][b], share = slope * scale / part.scale[b];
      equation[at + b] += scale * ((a == b ? 1 : 0) - slope);
      if (slope == 0) continue;
      const ContactSystem::Vector& along = s.g[part.at[b]];
      for (std::size_t k = 0; k < s.unknown_count; ++k) equation[k] += share * along[s.unknown[k]];
      equation[at + b] += share * kDamping * along[part.at[b]];
    }
    equation[at] -= scale * slopes.widening[a];
    s.right[at + a] = scale * (z[a] - s.p[part.at[a]]);
  }
}

// From the motions of residual(). Parts that should exert nothing exert nothing from now on; the others' forces are the
// unknowns.
bool newtonStep(ContactSystem& s) {
  std::array<bool, 2 * kMaxContactRows> exerts;
  bool moves = false;
  s.unknown_count = 0;
  for (std::size_t k = 0; k < s.part_count; ++k) {
    const ContactPart& part = s.parts[k];
    double z[3] = {};
    s.aim(part, z);
    s.nearest(part, z, nullptr);
    exerts[k] = z[0] != 0 || z[1] != 0 || z[2] != 0;
    for (std::size_t a = 0; a < part.size; ++a) {
      double& force = s.p[part.at[a]];
      if (exerts[k])
        s.unknown[s.unknown_count++] = part.at[a];
      else if (force != 0)
        force = 0, moves = true;
    }
  }
  if (moves) s.findMotions();
  std::size_t at = 0;
  for (std::size_t k = 0; k < s.part_count; ++k)
    if (exerts[k]) addEquations(s, s.parts[k], at), at += s.parts[k].size;
  s.products += 2.0 * static_cast<double>(s.unknown_count * s.unknown_count);
  if (!s.solveEquations()) return false;
  for (std::size_t k = 0; k < s.unknown_count; ++k) s.p[s.unknown[k]] += s.right[k];
  for (std::size_t i = 0; i < s.rows; ++i) s.p[i] = std::max(0.0, s.p[i]);
  ++s.iterations;
  return true;
}

// Newton's method with whole steps, which ever more sweeps start anew. If it fails, the forces are those that missed
// the laws by the least.
bool search(ContactSystem& s) {
  const double tolerance = s.problem.tolerance;
  double least = std::numeric_limits<double>::infinity();
  ContactSystem::Vector best;
  const auto missed = [&] {
    const double left = s.residual();
    if (left < least) least = left, std::copy_n(s.p.begin(), s.count, best.begin());
    return left;
  };
  for (int start = 0, count = kSweeps; start < kStarts && (start == 0 || !s.isSpent()); ++start) {
    s.allow();
    if (start > 0) {
      s.findMotions();
      for (int n = 0; n < count && !s.isSpent(); ++n) sweep(s);
      count *= 2;
    }
    double left = missed();
    for (int n = 0; n < kNewtonSteps && !(left <= kSolved * tolerance) && !s.isSpent(); ++n) {
      const double before = left;
      if (!newtonStep(s)) break;
      left = missed();
      if (left <= tolerance && left > 0.5 * before) break;  // rounding, or rows that repeat each other
    }
    if (left <= tolerance) return true;
  }
  std::copy_n(best.begin(), s.count, s.p.begin());
  return false;
}

// Where Coulomb's law is not found: two convex problems. The first holds the radii of the discs. The other's forces
// obey the law but for a contact that may lift off, by its friction times what its slip differs from that of the first
// (De Saxce and Feng). So friction is never overestimated.
void settle(ContactSystem& s, double most) {
  s.allow();
  s.most = s.rubs ? 0.5 * (s.products + most) : most;
  if (s.rubs) s.obey(Law::Discs);
  approachMinimum(s);
  if (!s.rubs) return;
  std::array<double, kMaxContactRows> lift{};
  for (std::size_t k = 0; k < s.part_count; ++k)
    if (const ContactPart& part = s.parts[k]; part.size == 3)
      s.q[part.at[0]] += lift[part.at[0]] = part.friction * std::hypot(s.w[part.at[1]], s.w[part.at[2]]);
  s.obey(Law::Cones);
  s.most = most;
  approachMinimum(s);
  s.obey(Law::Coulomb);
  for (std::size_t i = 0; i < s.rows; ++i) s.q[i] -= lift[i];
}

// Forces, and the coordinates of tool and groups that belong to them.
void keep(const ContactSystem& s, ContactProblem& problem) {
  problem.y = problem.target;
  problem.given = problem.rest;
  for (std::size_t i = 0; i < s.rows; ++i) {
    ContactRow& r = problem.rows[i];
    r.multiplier = s.p[i];
    if (!(s.p[i] > 0)) continue;
    problem.y += s.p[i] * r.a;
    if (r.group >= 0) problem.given[static_cast<std::size_t>(r.group)] += s.p[i] * r.give;
  }
  for (std::size_t i = s.rows; i < s.count; ++i) {
    FrictionDisc& d = problem.discs[(i - s.rows) / 2];
    const std::size_t axis = (i - s.rows) % 2;
    d.force[axis] = s.p[i];
    problem.y += s.p[i] * d.across[axis];
  }
}

}  // namespace

std::uint32_t solveForces(ContactProblem& problem, const SurfaceCompliance* compliance, std::uint32_t max_work) noexcept {
  ContactSystem system(problem, compliance);
  const double most = kProductsPerWork * max_work;
  system.most = 0.5 * most;
  problem.converged = search(system);
  if (!problem.converged) {
    settle(system, most);
    problem.converged = system.residual() <= problem.tolerance;
  }
  system.allow();
  keep(system, problem);
  problem.iterations = system.iterations;
  return static_cast<std::uint32_t>(kSolveWork + system.products / kProductsPerWork);
}

}  // namespace spheretree::runtime
