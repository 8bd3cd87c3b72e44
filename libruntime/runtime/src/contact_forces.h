// SPDX-License-Identifier: Apache-2.0
// The problem of contact_qp.h in its forces p alone, for contacts on soft tissue: the multipliers of the rows and the
// forces of the discs. With the motions w = q + G p of the rows and across,
//   rows:  p >= 0,  w >= 0,  p w = 0;     discs:  |p| <= radius, and where w is not 0, p = -radius w / |w|.
// G is what tool, groups and tissue give way by; of a disc with `law` the radius is that times the multiplier of its
// row. Tissue has as many ways to give way as there are forces, so this is smaller than the problem in coordinates.
//
// Method: without discs an active-set method, exact: the rows that press are solved for, one that comes to pull is left
// out, the one that is violated most is taken in; the objective falls with each change, so no set comes twice. With
// discs, projected Gauss-Seidel over the contacts, which always comes nearer and whose forces are in their cones
// whenever it ends, and after each few sweeps a step of Newton's method, which is taken where it comes nearer still.
// Papers: C. Lawson, R. Hanson. Solving Least Squares Problems. Prentice Hall 1974, chapter 23. M. Jean. The non-smooth
//         contact dynamics method. Comput. Methods Appl. Mech. Engrg. 177, 1999. P. Alart, A. Curnier. A mixed
//         formulation for frictional contact problems prone to Newton like solution methods. Ibid. 92, 1991.
// Units: as in contact_qp.h. No allocation. Deterministic.
#pragma once

#include <array>

#include "contact_qp.h"

namespace spheretree::runtime {

inline constexpr std::size_t kMostForces = 3 * kMostContactRows;  // of rows, and two of each disc

/// The force of disc `disc` along one of its axes; that of a row is the number of the row.
constexpr std::size_t forceOf(std::size_t disc, std::size_t axis) { return kMostContactRows + 2 * disc + axis; }

/// (force, force) the motion of the surface by one force, at the point and along the direction of the other; 0
/// between those that are on no tissue. Symmetric and positive semidefinite; read are those of the rows and discs
/// that there are.
using SurfaceCompliance = std::array<std::array<double, kMostForces>, kMostForces>;

/// Solves `qp`, whose discs have radii or a law and are no cones, with this compliance. Forces and multipliers in
/// it are the guess. qp.converged: to qp.tolerance; otherwise the result is as near as it came. Cost: about 1 us
/// for each change of the rows that press; with discs, 3 us for each of `qp.iterations` and five contacts. Returns
/// it in groups of rows.
std::uint32_t solveForces(ContactQp& qp, const SurfaceCompliance& compliance) noexcept;

}  // namespace spheretree::runtime
