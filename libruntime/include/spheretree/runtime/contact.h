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
  float smallest_gap = 0;         // [mm]; +infinity without rows
};

/// Rows of `pairs` for the tool at `pose`. Held by `workspace` until the next call. Centres that coincide get the normal +z.
/// `axes`: columns are the axes about which the three angles turn, world axes; the identity for rotation vectors.
/// Cost: about 1.5 ns a row. No allocation.
RowSet makeRows(const Scene& scene, const PairSet& pairs, const Configuration& pose, RowForm form, const Eigen::Matrix3d& axes,
                Workspace& workspace) noexcept;

/// Bridges that the tool, at `pose`, may touch before it has moved by `margin` [mm], into workspace.near_bridges. `rows`: of `pairs` at
/// `pose`; `pairs` holds what is within `margin` + Scene::deepest_bridge. Cost: some 10 ns for each bridge of each near pair. No
/// allocation.
void findBridges(const Scene& scene, const PairSet& pairs, const Configuration& pose, double margin, const RowSet& rows,
                 Workspace& workspace) noexcept;

/// Adds to `rows`, which makeRows() made as true distances at `pose`, those of workspace.near_bridges whose gap is at most `most_gap` [mm].
/// Names them in workspace.bridge_rows. A bridge is convex, so its row is as safe as that of a pair. Cost: some 15 ns each. No allocation.
void addBridgeRows(const Scene& scene, const Configuration& pose, double most_gap, RowSet& rows, Workspace& workspace) noexcept;

}  // namespace spheretree::runtime
