// SPDX-License-Identifier: GPL-3.0-or-later
// The least worst-case error of a scene for a given number of leaves, or for given microseconds of each step. How: docs/batch.md
#pragma once

#include <cstddef>
#include <vector>

#include "batch/batch_items.h"
#include "batch/error_curve.h"
#include "batch/step_cost.h"

namespace spheretree::tool {

struct Budget {
  double amount = 0;     // > 0: leaves of all trees together, or
  bool is_time = false;  // microseconds of a step, by stepModel()
};

/// Builds all that waits in `items` within the budget. What came as a tree counts and stays. `hands`: the hands of a budget of time;
/// none: touches at random. Gives the field `budget` of the report.
/// @throws UsageError if an item has another builder than cover or a leaf for each tree is too much; Cancelled.
Json buildWithin(const Budget& budget, const formats::SceneFile& scene, std::vector<Item>& items, WorkSite* site, Hands hands,
                 const Workshop& workshop);

}  // namespace spheretree::tool
