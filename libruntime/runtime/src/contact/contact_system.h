// SPDX-License-Identifier: Apache-2.0
// The matrices of a contact problem, forces with their motions, and by how much they miss their laws.
#pragma once

#include <array>

#include "contact/contact_laws.h"
#include "contact/contact_problem.h"

namespace spheretree::runtime {

inline constexpr double kSolved = 0.02;  // share of the tolerance at which a solver stops

/// p: forces, those of the rows and then two of each disc. w = q + g p: their motions.
struct ContactSystem {
  using Vector = std::array<double, kMaxForces>;

  ContactSystem(const ContactProblem& of, const SurfaceCompliance* compliance);

  const ContactProblem& problem;
  const std::size_t rows, count;
  std::array<Vector, kMaxForces> g;
  Vector q, p, w;
  std::array<ContactPart, 2 * kMaxContactRows> parts;
  std::size_t part_count = 0;
  bool rubs = false;  // some contact has a friction
  Law law = Law::Coulomb;
  int iterations = 0;   // Newton steps
  double products = 0;  // of numbers, as a measure of work,
  double most = 0;      // of which no more are begun after so many
  bool isSpent() const { return products > most; }

  /// From the present forces, which determine the radii of Law::Discs.
  void obey(Law next);
  void findMotions();
  void change(std::size_t force, double by);
  /// The forces of the part, less its motions by their scales: a force obeys its law if it is the nearest allowed one.
  void aim(const ContactPart& part, double* z) const;
  void nearest(const ContactPart& part, double* z, Slopes* slopes) const { nearestForce(law, part, p[part.at[0]], z, slopes); }
  /// Moves the forces to the nearest ones that are allowed.
  void allow();
  /// How far the motions are from what the laws ask for, at most [mm, scaled]; leaves them in w.
  double residual();

  // Linear equations for `unknown_count` of the forces.
  std::array<std::size_t, kMaxForces> unknown;
  std::size_t unknown_count = 0;
  std::array<Vector, kMaxForces> matrix;
  Vector right;
  /// By Gauss's elimination with pivots; the answer is in `right`. False: they are singular.
  bool solveEquations();

 private:
  double product(std::size_t i, std::size_t j) const;
  void listParts();
};

}  // namespace spheretree::runtime
