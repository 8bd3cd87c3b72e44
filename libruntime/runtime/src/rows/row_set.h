// SPDX-License-Identifier: Apache-2.0
// The rows of the contacts in the neighbourhood of a pose, in the memory of a step; rows.h makes them.
#pragma once

#include <cstdint>

#include "contact/qp6.h"

namespace spheretree::runtime {

/// Rows at the pose for which they were made.
struct RowSet {
  QpRows rows;
  float* b = nullptr;             // the same right-hand sides, for changes
  const float* weight = nullptr;  // 1 / length of the row before scaling: gap_i = -b_i / weight_i [mm]
  const float* along = nullptr;   // of a tool of hulls: where the touched point is along the normal, from the reference point [mm]
  std::uint32_t guarded =
      0;                   // number of rows of leaves and of flat triangles, one for each pair; the rows after them are of smooth patches
  float smallest_gap = 0;  // of the guarded rows [mm]; +infinity if there are none
  float smallest_felt_gap = 0;  // of the rows of smooth patches [mm]; +infinity if there are none
};

}  // namespace spheretree::runtime
