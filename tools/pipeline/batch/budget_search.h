// SPDX-License-Identifier: GPL-3.0-or-later
// The least worst-case error of a scene for a given number of leaves, or for given microseconds of each step. How:
// docs/batch.md
#pragma once

#include <vector>

#include "pipeline/batch/batch_items.h"
#include "pipeline/batch/batch_result.h"
#include "pipeline/batch/step_cost.h"

namespace spheretree::pipeline {

/// Builds all that waits in `items` within the budget. What came as a tree counts and stays. `paths`: those whose steps
/// a budget of time counts; none: random contacts.
/// @throws tool::UsageError if an item has another builder than cover, or if a leaf for each tree is more than the
/// budget; Cancelled.
BudgetResult buildWithin(const Budget& budget, std::vector<BatchItem>& items, ToolPaths paths, const BatchContext& context);

}  // namespace spheretree::pipeline
