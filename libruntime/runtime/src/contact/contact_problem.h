// SPDX-License-Identifier: Apache-2.0
// The contact problem of a piece: contacts with friction, on objects and tissue that yield, in their forces.
//
// p holds the multipliers u_i of the rows and, of each contact with friction, the two components of its force f across
// the normal. The motions that belong to them, along the rows and across the normals, are
//
//   w = q + G p        G = J J^T + E E^T + C
//
// J maps the step y of the tool (6 coordinates, as in qp6.h, against springs of unit stiffness) to w, E maps how far
// groups of rows yield together (each against a spring of its own), and C is the compliance of soft tissue. q is the
// motion without forces. The solution obeys
//
//   rows:     u_i >= 0,  w_i >= 0,  u_i w_i = 0
//   contacts: |f| <= r, and where the contact slips, v != 0:  f = -r v / |v|        r = friction u, or a given radius
//
// v is the part of w across the normal, less the motion `origin` of the object. G is symmetric and positive
// semidefinite. Without friction, and with given radii, this is the minimum of p G p / 2 + q p under the bounds of
// p, and w is unique. With Coulomb's law a solution exists if some step separates all rows; there may be several.
//
// Units: y in mm (scaled); forces are divided by the translation stiffness of the coupling [mm].
#pragma once

#include <array>

#include "contact/qp6.h"

namespace spheretree::runtime {

inline constexpr int kMaxGroups = 8;

/// a . y + give d(group) >= b, in the step y of the tool and the coordinate d of the group.
struct ContactRow {
  Vector6 a = Vector6::Zero();
  double b = 0;
  int group = -1;         // group with which it yields, or -1
  double give = 0;        // coefficient of the group's coordinate
  double multiplier = 0;  // >= 0; input: an initial guess
};

struct FrictionDisc {
  std::array<Vector6, 2> across{Vector6::Zero(), Vector6::Zero()};  // the motion of the tool's point across the normal, by y
  std::array<double, 2> origin{};                                   // motion of the object there
  int row = 0;                                                      // of the contact
  double friction = 0;            // > 0: Coulomb's law; the radius is `friction` times the multiplier of the row
  double radius = 0;              // >= 0; used if `friction` is 0
  std::array<double, 2> force{};  // on the tool; input: an initial guess
};

struct ContactProblem {
  std::array<ContactRow, kMaxContactRows> rows;
  std::array<FrictionDisc, kMaxContactRows> discs;
  std::array<double, kMaxGroups> rest{}, given{};  // d that the group would have alone, and d
  int row_count = 0, disc_count = 0, group_count = 0;
  Vector6 target = Vector6::Zero(), y = Vector6::Zero();  // the step without forces, and with them
  double tolerance = 1e-8;                                // of the motions, by which the laws may be missed [mm, scaled]
  int iterations = 0;                                     // Newton steps
  bool converged = false;                                 // the laws hold within `tolerance`
};

inline constexpr std::size_t kMaxForces = 3 * kMaxContactRows;  // of rows, and two of each disc

/// The force of disc `disc` along one of its axes; that of a row is the number of the row.
constexpr std::size_t forceOf(std::size_t disc, std::size_t axis) { return kMaxContactRows + 2 * disc + axis; }

/// C: (force, force) motion of the surface at the point and along the direction of one force, caused by a unit of the
/// other; 0 unless both are on tissue. Symmetric and positive semidefinite. Only the entries of existing rows and discs
/// are read.
using SurfaceCompliance = std::array<std::array<double, kMaxForces>, kMaxForces>;

}  // namespace spheretree::runtime
