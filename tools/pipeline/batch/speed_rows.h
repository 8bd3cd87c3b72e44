// SPDX-License-Identifier: GPL-3.0-or-later
// Speed against accuracy of a scene and of each of its objects, from few to many leaves: the field `pareto` of
// report.json.
#pragma once

#include <vector>

#include "pipeline/batch/batch_items.h"
#include "pipeline/batch/batch_result.h"
#include "pipeline/batch/step_cost.h"

namespace spheretree::pipeline {

/// Rows for each object alone and for the scene: one for 8, 64, 512 and 4,096 leaves, which are the levels of one quick
/// tree of each object; one for each tolerance in the scene, with quick trees where the chosen ones have another
/// tolerance; and one for the chosen trees, those of `items`. `source`: the items before they were built. `paths`: the
/// paths whose steps are measured; empty: random contacts. Rows and fields: docs/batch.md
/// @throws Cancelled
std::vector<SpeedRow> speedRows(const std::vector<BatchItem>& source, const std::vector<BatchItem>& items, ToolPaths paths,
                                const BatchContext& context);

}  // namespace spheretree::pipeline
