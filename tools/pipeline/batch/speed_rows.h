// SPDX-License-Identifier: GPL-3.0-or-later
// Speed against accuracy of a scene and of each of its objects, from few leaves to many: the field `pareto` of
// report.json.
#pragma once

#include <vector>

#include "pipeline/batch/batch_items.h"
#include "pipeline/batch/batch_result.h"
#include "pipeline/batch/step_cost.h"

namespace spheretree::pipeline {

/// One row for each object alone, and for the scene, for each number of leaves from 8 to 4,096 and each tolerance that
/// the scene gives, all with quick trees; and one for what was chosen: the trees of `items`, as they are. `source`: the
/// items before they were built.
/// `paths`: those whose steps are measured; empty: random contacts. Rows and fields: docs/batch.md
/// @throws Cancelled
std::vector<SpeedRow> speedRows(const std::vector<BatchItem>& source, const std::vector<BatchItem>& items, ToolPaths paths,
                                const BatchContext& context);

}  // namespace spheretree::pipeline
