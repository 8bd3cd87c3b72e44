// SPDX-License-Identifier: Apache-2.0
// The table of the inner loops, for the instruction set of the source that includes it. One header for each loop:
// NAME_lanes.h, on the vectors of lanes.h.
#pragma once

#include "felt_rows_lanes.h"
#include "find_pairs_lanes.h"
#include "flat_rows_lanes.h"
#include "kernel.h"
#include "sphere_rows_lanes.h"
#include "worst_row_lanes.h"

namespace spheretree::runtime {
namespace {

constexpr KernelTable kTable{findNear, findPairs, sphereRows, flatRows, feltRows, worstRow};

}  // namespace
}  // namespace spheretree::runtime
