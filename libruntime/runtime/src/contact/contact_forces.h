// SPDX-License-Identifier: Apache-2.0
// The problem of contact_qp.h, expressed in its forces p alone, for contacts on soft tissue. p holds the multipliers of
// the rows and the forces of the discs. The motions along the rows and across them are w = q + G p, and
//   rows:  p >= 0,  w >= 0,  p w = 0;     discs:  |p| <= radius, and where w is not 0, p = -radius w / |w|.
// G is the compliance of tool, groups and tissue together. The radius of a disc with `law` is `law` times the
// multiplier of its row. Tissue would need one coordinate for each force, so the problem in forces is the smaller one.
//
// Method without discs: an exact active-set method. It solves for the active rows, removes a row whose force would
// pull, and adds the row that is violated most. The objective decreases with each change, so no active set occurs
// twice. Method with discs: some sweeps of projected Gauss-Seidel over the contacts, and then rounds of a Newton step
// on the active rows and all their discs, with a line search on the residual. A step that does not halve it is followed
// by more sweeps each time; they are kept if they lower it. In the end the forces are projected onto their cones.
// Papers: C. Lawson, R. Hanson. Solving Least Squares Problems. Prentice Hall 1974, chapter 23. M. Jean. The non-smooth
// contact dynamics method. Comput. Methods Appl. Mech. Engrg. 177, 1999. P. Alart, A. Curnier. A mixed formulation for
// frictional contact problems prone to Newton like solution methods. Ibid. 92, 1991. S. Hueber, G. Stadler, B.
// Wohlmuth. A primal-dual active set algorithm for three-dimensional contact problems with Coulomb friction. SIAM J.
// Sci. Comput. 30(2), 2008. Units: as in contact_qp.h. No allocation. Deterministic.
#pragma once

#include <array>

#include "contact/contact_qp.h"

namespace spheretree::runtime {

inline constexpr std::size_t kMaxForces = 3 * kMaxContactRows;  // of rows, and two of each disc

/// The force of disc `disc` along one of its axes; that of a row is the number of the row.
constexpr std::size_t forceOf(std::size_t disc, std::size_t axis) { return kMaxContactRows + 2 * disc + axis; }

/// (force, force) motion of the surface at the point and along the direction of one force, caused by a unit of the
/// other; 0 unless both are on tissue. Symmetric and positive semidefinite. Only the entries of existing rows and discs
/// are read.
using SurfaceCompliance = std::array<std::array<double, kMaxForces>, kMaxForces>;

/// Solves `qp` with this compliance. Its discs must have a radius or a law; cones are not supported. The forces and
/// multipliers in `qp` are the initial guess. If `qp.converged` is false, the result is the last iterate. Returns the
/// work, in groups of rows. Cost: about 1 us for each change of the active rows; with discs, 6 us for each of
/// `qp.iterations` and five contacts.
std::uint32_t solveForces(ContactQp& qp, const SurfaceCompliance& compliance) noexcept;

}  // namespace spheretree::runtime
