// SPDX-License-Identifier: Apache-2.0
// The table of the inner loops, for the instruction set of the source that includes it. One header for each loop:
// NAME_lanes.h, on the vectors of lanes.h.
#pragma once

#include "kernel/felt_rows_lanes.h"
#include "kernel/find_pairs_lanes.h"
#include "kernel/flat_rows_lanes.h"
#include "kernel/hull_balls_lanes.h"
#include "kernel/kernel.h"
#include "kernel/sphere_rows_lanes.h"
#include "kernel/worst_row_lanes.h"

namespace spheretree::runtime {
namespace {

constexpr KernelTable kTable{findNear, findPairs, spreadWays, sphereRows, flatRows, keepResting, feltRows, worstRow};

}  // namespace
}  // namespace spheretree::runtime
