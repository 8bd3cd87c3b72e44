// SPDX-License-Identifier: GPL-3.0-or-later
// Speed against accuracy of a scene and of each of its objects, from few leaves to many: the field `pareto` of report.json.
#pragma once

#include <vector>

#include "batch/batch_items.h"
#include "batch/step_cost.h"

namespace spheretree::tool {

/// One row for each object alone, and for the scene (`object` null), for each number of leaves from 8 to 4,096 and each tolerance that the
/// scene gives, all with quick trees; and one for what was chosen: the trees of `items`, as they are. `source`: the items before they were
/// built. `hands`: whose steps are measured; empty: touches at random. Rows and fields: docs/batch.md
/// @throws Cancelled
Json paretoOf(const formats::SceneFile& scene, const std::vector<Item>& source, const std::vector<Item>& items, WorkSite* site, Hands hands,
              const Workshop& workshop);

}  // namespace spheretree::tool
