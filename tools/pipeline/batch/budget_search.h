// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest worst-case error of a scene for a given number of leaves, or for a given time of each step in
// microseconds. Method: docs/batch.md
#pragma once

#include <vector>

#include "pipeline/batch/batch_items.h"
#include "pipeline/batch/batch_result.h"
#include "pipeline/batch/step_cost.h"

namespace spheretree::pipeline {

/// Builds all waiting `items` within the budget. Items that came as trees count, and do not change. `paths`: the paths
/// whose steps a budget of time counts; empty: random contacts.
/// @throws tool::UsageError if an item has a builder other than cover, or if the budget is below one leaf for each
/// tree; Cancelled.
BudgetResult buildWithin(const Budget& budget, std::vector<BatchItem>& items, ToolPaths paths, const BatchContext& context);

}  // namespace spheretree::pipeline
