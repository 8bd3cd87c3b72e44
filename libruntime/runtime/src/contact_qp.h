// SPDX-License-Identifier: Apache-2.0
// The step of a tool that rests on rows which give way and which rub:
//
//   minimise  |y - target|^2 / 2  +  sum_g (d_g - rest_g)^2 / 2  +  |z|^2 / 2  +  sum_i radius_i |T_i y - origin_i|
//   subject to  c_k(y, d, z) = a_k . y + give_k d_g(k) + sum_m tissue_km z_m - b_k >= -compliance_k multiplier_k
//               c_k(i) + friction_i slip_i >= friction_i |T_i y - origin_i|          for discs with friction > 0
//
// y is the step of the tool as in qp6.h. d_g is how far a group of rows gives way together, against a spring of its
// own; `compliance` is that of one row alone, but not of its cone. Rows of soft tissue give way under each other's
// forces, by the matrix tissue tissue^T times their multipliers. T_i takes y to the motion of a point of the tool
// across the normal of a contact. The force of friction there is bounded by a disc of a given radius, or, with friction
// > 0, by friction times the multiplier of the contact itself: a second-order cone. Such a cone lets the contact go off
// its row where it slips by more than `slip` (G. De Saxce, Z.-Q.
// Feng. The bipotential method. Math. Comput. Modelling 28, 1998): with slip_i = |T_i y - origin_i| the answer obeys
// Coulomb's law. The problem is strictly convex: one answer, whatever the order of rows. Where T_i y = origin_i the
// contact sticks, exactly. In place of a disc of a given radius or a cone, Coulomb's law itself can be asked for:
// nothing is minimised then, and an answer may not be found.
//
// Method: augmented Lagrangian, whose inner problem is smooth but for its second derivative and is solved by a Newton
// method. M. Hestenes. Multiplier and gradient methods. JOTA 4, 1969. R. T. Rockafellar. Augmented Lagrangians and
// applications of the proximal point algorithm in convex programming. Math. Oper. Res. 1(2), 1976. L. Qi, J. Sun. A
// nonsmooth version of Newton's method. Math. Programming 58, 1993. Without discs: rows_alone_qp.cpp.
// Units: mm (scaled), forces over the stiffness of translation [mm]. No allocation. Deterministic.
#pragma once

#include <array>

#include "qp6.h"

namespace spheretree::runtime {

inline constexpr int kMostGroups = 8;

struct ContactRow {
  Vector6 a = Vector6::Zero();
  double b = 0;
  double compliance = 0;  // >= 0; 0: hard [1]
  int group = -1;         // that gives way, or -1
  double give = 0;        // of the group's coordinate
  double multiplier = 0;  // >= 0; in: a guess
};

struct FrictionDisc {
  std::array<Vector6, 2> across{Vector6::Zero(), Vector6::Zero()};  // rows of T
  std::array<double, 2> origin{};
  double radius = 0;              // >= 0; of a disc, if `law` is 0
  double law = 0;                 // > 0: Coulomb's; the radius is that of the answer, `law` times the multiplier of the row `row`
  std::array<double, 2> force{};  // on the tool, against T y - origin; in: a guess
  double friction = 0;            // > 0: a cone about the row `row`, which presses with its multiplier and `pressure`
  double slip = 0, pressure = 0;  // >= 0; pressure in: a guess
  int row = 0;
};

struct ContactQp {
  std::array<ContactRow, kMostContactRows> rows;
  std::array<FrictionDisc, kMostContactRows> discs;
  std::array<double, kMostGroups> rest{}, given{};                            // d that the group would like, and d; given in: a guess
  std::array<std::array<double, kMostContactRows>, kMostContactRows> tissue;  // (row, coordinate), of all coordinates that there are
  std::array<double, kMostContactRows> tissue_given{};                        // z; in: a guess
  int row_count = 0, disc_count = 0, group_count = 0, tissue_count = 0;
  Vector6 target = Vector6::Zero(), y = Vector6::Zero();  // y in: a guess
  double tolerance = 1e-8;                                // of residuals [mm, scaled]
  int iterations = 0;                                     // Newton steps
  bool converged = false;                                 // residuals within `tolerance`
};

/// The rows must have a common solution. Cost: about 0.1 us, and 10 ns for each row and disc, an iteration; 2 to 6
/// iterations from the multipliers of the step before.
void solveContactQp(ContactQp& qp) noexcept;

/// The same of a problem without discs, exactly. False, with the problem as it was but for `iterations`, if rows
/// contradict each other or rounding is in the way. Cost: about 1 us for each change of the rows that press.
bool solveRowsAlone(ContactQp& qp) noexcept;

}  // namespace spheretree::runtime
