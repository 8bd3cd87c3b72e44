// SPDX-License-Identifier: Apache-2.0
// From pairs to rows: the non-penetration of each pair, linearised at a pose of the tool, in the scaled coordinates of
// the QP, y = (translation [mm], angle_length * rotation [mm]). A row is (n, (r x n) / angle_length) divided by its
// length, where n is the unit normal from object to tool and r points from the reference point to the tool sphere's
// centre.
//
// A pair with a triangle of a skin has up to two rows. The guaranteed row keeps the ball, reduced by the allowance of
// the triangle, out of the flat triangle, which is convex. In the felt row the ball rests on the smooth patch over the
// triangle (docs/runtime.md, Skin).
#pragma once

#include <cstdint>

#include "rows/row_set.h"
#include "spheretree/core/rigid.h"
#include "state/pair_set.h"

namespace spheretree::runtime {

struct StepMemory;

enum class RowForm {
  TrueDistance,     // gap = d - R; rotation vector. d is convex in a translation, so the linearised row underestimates the gap
  SquaredDistance,  // the paper's C = d^2 - R^2 >= 0 at the pose, divided by 2 d; Euler angles (gamma, beta, alpha)
};

/// Makes the rows of leaves and flat triangles with the tool at `pose`, one for each of `pairs`. They are stored in
/// `memory` until the next call. Coinciding centres get the normal +z. `axes`: its columns are the axes of the three
/// rotation angles, in world axes; the identity for rotation vectors. Inner nodes of a coarse set count as balls. Cost:
/// about 1.5 ns for a pair of leaves, 4 ns for one with a triangle. No allocation.
RowSet makeRows(const PairSet& pairs, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes, StepMemory& memory) noexcept;

/// Removes the pairs and rows with a gap above `margin` [mm]. `pairs` must be the result of the last search, and `rows`
/// its rows at the current pose. Cost: about 2 ns a pair. No allocation.
void keepNear(double margin, PairSet& pairs, RowSet& rows, StepMemory& memory) noexcept;

/// The pairs among `pairs` that get felt rows: those with a curved patch that the ball can touch when it moves by at
/// most `way` [mm]. `pairs` must be those of the last makeRows(). Stored in `memory` until the next call. Cost: about 1
/// ns a pair. No allocation.
PairSet feltPairs(const PairSet& pairs, double way, StepMemory& memory) noexcept;

/// Adds the felt row of each pair in `felt` to `rows`, which makeRows() made at `pose`. Pairs with a cone or slab that
/// cannot rest on its patch are first left out of `felt`. The plane beside a patch is left out if its gap exceeds
/// `max_gap` [mm]. Cost: about 40 ns a pair that is left. No allocation.
void addFeltRows(PairSet& felt, const Configuration& pose, double max_gap, RowSet& rows, StepMemory& memory) noexcept;

}  // namespace spheretree::runtime
