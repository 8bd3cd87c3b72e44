// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of `spheretree evaluate` as JSON, schema spheretree.evaluation/1.
#pragma once

#include <nlohmann/json.hpp>

#include "spheretree/builder/evaluate_tree.h"

namespace spheretree::tool {

nlohmann::ordered_json evaluationJson(const builder::Evaluation& evaluation);

}  // namespace spheretree::tool
