// SPDX-License-Identifier: Apache-2.0
// Pairs to rows: the non-penetration of each pair, linearised at a pose of the tool, in the scaled coordinates of the
// QP. y = (translation [mm], angle_length * rotation [mm]); a row is (n, (r x n) / angle_length) divided by its length,
// where n is the unit normal from object to tool and r the tool sphere's centre from the reference point.
//
// A pair with a triangle of a skin has up to two rows. What is guaranteed: the ball, smaller by what the triangle gives
// way, stays out of the flat triangle, which is convex. What is felt: the ball rests on the smooth patch over it
// (docs/runtime.md, Skin).
#pragma once

#include <cstdint>

#include "find_pairs.h"
#include "qp6.h"

namespace spheretree::runtime {

enum class RowForm {
  TrueDistance,     // gap = d - R; rotation vector. d is convex in a translation, so the row is on the safe side of it
  SquaredDistance,  // the paper's C = d^2 - R^2 >= 0 about the pose, divided by 2 d; Euler angles (gamma, beta, alpha)
};

/// What a set of rows says at the pose at which it was made.
struct RowSet {
  QpRows rows;
  float* b = nullptr;             // the same right-hand sides, to be moved
  const float* weight = nullptr;  // 1 / length of the row before scaling: gap_i = -b_i / weight_i [mm]
  std::uint32_t guarded = 0;      // rows of leaves and of flat triangles, one for each pair; those that follow are of smooth patches
  float smallest_gap = 0;         // of the guarded rows [mm]; +infinity without rows
  float smallest_felt_gap = 0;    // of the others [mm]; +infinity without
};

/// Rows of leaves and flat triangles for the tool at `pose`, one for each of `pairs`. Held by `memory` until the next
/// call. Centres that coincide get the normal +z. `axes`: columns are the axes about which the three angles turn, world
/// axes; the identity for rotation vectors. Inner nodes of a coarse set count as balls. Cost: about 1.5 ns a pair of
/// leaves, 4 ns one with a triangle. No allocation.
RowSet makeRows(const PairSet& pairs, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes, StepMemory& memory) noexcept;

/// Of `pairs`, the last that were found, and of their `rows` at this pose, those whose gap is at most `margin` [mm].
/// Cost: about 2 ns a pair. No allocation.
void keepNear(double margin, PairSet& pairs, RowSet& rows, StepMemory& memory) noexcept;

/// The pairs among `pairs`, whose rows makeRows() made last, that have felt rows: those with a curved patch that the
/// ball can come to touch on a way of `way` [mm]. Held by `memory` until the next call. Cost: about 1 ns a pair. No
/// allocation.
PairSet feltPairs(const PairSet& pairs, double way, StepMemory& memory) noexcept;

/// Adds to `rows`, which makeRows() made at `pose`, the felt row of each of `felt`. A plane beside a patch that is
/// farther off than `most_gap` [mm] is left out. Cost: about 40 ns a pair. No allocation.
void addFeltRows(const PairSet& felt, const Configuration& pose, double most_gap, RowSet& rows, StepMemory& memory) noexcept;

}  // namespace spheretree::runtime
