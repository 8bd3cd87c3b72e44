// SPDX-License-Identifier: Apache-2.0
// The step of a tool in contact, where rows may yield and contacts may have friction:
//
//   minimise  |y - target|^2 / 2  +  sum_g (d_g - rest_g)^2 / 2  +  sum_i radius_i |T_i y - origin_i|
//   subject to  c_k(y, d) = a_k . y + give_k d_g(k) - b_k >= -compliance_k multiplier_k
//               c_k(i) + friction_i slip_i >= friction_i |T_i y - origin_i|          for discs with friction > 0
//
// y is the step of the tool as in qp6.h. d_g is how far a group of rows yields together, against a spring of its own;
// `compliance` is that of one row alone, but not of its cone. T_i maps y to the tangential motion of the tool's point
// at a contact. The force of friction there is bounded by a disc of a given radius or, with friction > 0, by friction
// times the multiplier of the contact itself: a second-order cone. Such a cone allows the contact to separate from its
// row where it slips by more than `slip` (G. De Saxce, Z.-Q. Feng. The bipotential method. Math. Comput. Modelling 28,
// 1998): with slip_i = |T_i y - origin_i| the solution obeys Coulomb's law. The problem is strictly convex, so its
// solution does not depend on the order of rows. Where T_i y = origin_i the contact sticks, exactly. Instead of a disc
// of a given radius or a cone, Coulomb's law itself can be requested: then nothing is minimised, and a solution may not
// be found. Contacts on soft tissue yield under each other's forces, too: contact_forces.h.
//
// Method: augmented Lagrangian, whose inner problem has a continuous gradient and is solved by a Newton method. M.
// Hestenes. Multiplier and gradient methods. JOTA 4, 1969. R. T. Rockafellar. Augmented Lagrangians and applications of
// the proximal point algorithm in convex programming. Math. Oper. Res. 1(2), 1976. L. Qi, J. Sun. A nonsmooth version
// of Newton's method. Math. Programming 58, 1993.
// Units: mm (scaled); forces are divided by the translation stiffness [mm]. No allocation. Deterministic.
#pragma once

#include <array>

#include "contact/qp6.h"

namespace spheretree::runtime {

inline constexpr int kMaxGroups = 8;

struct ContactRow {
  Vector6 a = Vector6::Zero();
  double b = 0;
  double compliance = 0;  // >= 0; 0: hard [1]
  int group = -1;         // group with which it yields, or -1
  double give = 0;        // coefficient of the group's coordinate
  double multiplier = 0;  // >= 0; input: an initial guess
};

struct FrictionDisc {
  std::array<Vector6, 2> across{Vector6::Zero(), Vector6::Zero()};  // rows of T
  std::array<double, 2> origin{};
  double radius = 0;              // of a disc, >= 0; used if `law` is 0
  double law = 0;                 // > 0: Coulomb's law; the radius is `law` times the multiplier of the row `row` in the solution
  std::array<double, 2> force{};  // on the tool, opposite to T y - origin; input: an initial guess
  double friction = 0;            // > 0: a cone about the row `row`, whose force is its multiplier and `pressure`
  double slip = 0, pressure = 0;  // >= 0; input of pressure: an initial guess
  int row = 0;
};

struct ContactQp {
  std::array<ContactRow, kMaxContactRows> rows;
  std::array<FrictionDisc, kMaxContactRows> discs;
  std::array<double, kMaxGroups> rest{}, given{};  // d that the group would have alone, and d; input of `given`: an initial guess
  int row_count = 0, disc_count = 0, group_count = 0;
  Vector6 target = Vector6::Zero(), y = Vector6::Zero();  // input of y: an initial guess
  double tolerance = 1e-8;                                // of the residuals [mm, scaled]
  int iterations = 0;                                     // Newton steps
  bool converged = false;                                 // residuals within `tolerance`
  bool holds_friction = false;                            // only with solveForces(): the forces of the discs stay the given ones
};

/// The rows must have a common solution. Cost of an iteration: about 0.1 us, and 10 ns for each row and disc; 2 to 6
/// iterations from the multipliers of the step before.
void solveContactQp(ContactQp& qp) noexcept;

}  // namespace spheretree::runtime
