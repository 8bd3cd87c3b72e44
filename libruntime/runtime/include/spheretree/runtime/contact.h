// SPDX-License-Identifier: Apache-2.0
// Pairs to rows: the non-penetration of each pair, linearised at a pose of the tool, in the scaled coordinates of the QP.
// y = (translation [mm], angle_length * rotation [mm]); a row is (n, (r x n) / angle_length) divided by its length, where n is the unit
// normal from object to tool and r the tool sphere's centre from the reference point.
#pragma once

#include <cstdint>

#include "spheretree/runtime/collide.h"
#include "spheretree/runtime/qp6.h"

namespace spheretree::runtime {

enum class RowForm {
  TrueDistance,     // gap = d - R; rotation vector. d is convex in a translation, so the row is on the safe side of it
  SquaredDistance,  // the paper's C = d^2 - R^2 >= 0 about the pose, divided by 2 d; Euler angles (gamma, beta, alpha)
};

/// What a set of rows says at the pose at which it was made.
struct RowSet {
  QpRows rows;
  const float* weight = nullptr;  // 1 / length of the row before scaling: gap_i = -b_i / weight_i [mm]
  std::uint32_t leaf_count = 0;   // rows of pairs of leaves; those that follow are of bridges
  float smallest_gap = 0;         // of leaves [mm]; +infinity without rows
};

/// Rows of `pairs` for the tool at `pose`. Held by `workspace` until the next call. Centres that coincide get the normal +z.
/// `axes`: columns are the axes about which the three angles turn, world axes; the identity for rotation vectors.
/// Cost: about 1.5 ns a row. No allocation.
RowSet makeRows(const Scene& scene, const PairSet& pairs, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes,
                Workspace& workspace) noexcept;

/// Of findBridges() those that a leaf of the tool may come to touch before it has moved by `margin` [mm], its place over the bridge
/// considered. Cost: about 3 ns more for each. No allocation.
PairSet findNearBridges(const Scene& scene, const Configuration& pose, double margin, std::uint32_t max_work,
                        Workspace& workspace) noexcept;

/// Leaves of `pairs`, whose `rows` are those of true distances at `pose`, those within `margin`, and of `bridges` as findNearBridges() at
/// this pose. Both must be the last that were found; the rows are those of the old lists. Cost: about 1 ns a pair, 3 ns a bridge. No
/// allocation.
void narrow(const Scene& scene, const RowSet& rows, const Configuration& pose, double margin, PairSet& pairs, PairSet& bridges,
            Workspace& workspace) noexcept;

/// Adds to `rows`, which makeRows() made as true distances at `pose`, one for each of `bridges`: that of its nearest point, where this lies
/// between its leaves and the gap is at most `most_gap` [mm] and no deeper than kDeepestDip; else one that is in no one's way. A bridge is
/// convex, so its row is as safe as that of a pair. `bridges`: of the last findNearBridges(). Cost: about 3 ns each. No allocation.
void addBridgeRows(const Scene& scene, const PairSet& bridges, const Configuration& pose, double most_gap, RowSet& rows,
                   Workspace& workspace) noexcept;

}  // namespace spheretree::runtime
