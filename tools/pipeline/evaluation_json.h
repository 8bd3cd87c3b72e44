// SPDX-License-Identifier: GPL-3.0-or-later
// The figures of `spheretree evaluate` as JSON, schema spheretree.evaluation/1. Figures that are not in the JSON (the
// outside area, the index of the worst sphere) are lost in a round trip.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "spheretree/builder/evaluation.h"
#include "spheretree/core/hulls.h"

namespace spheretree::pipeline {

nlohmann::ordered_json evaluationJson(const builder::Evaluation& evaluation);

/// An element of `levels`, to and from JSON. @throws nlohmann::json::exception if a key is missing or of another type.
nlohmann::ordered_json levelJson(const builder::LevelEvaluation& level);
builder::LevelEvaluation levelFromJson(const nlohmann::ordered_json& json);

/// The field `skin`, to and from JSON. @throws as levelFromJson().
nlohmann::ordered_json skinJson(const builder::SkinEvaluation& skin);
builder::SkinEvaluation skinFromJson(const nlohmann::ordered_json& json);
/// The field `hulls` of an evaluation.
nlohmann::ordered_json hullsJson(const builder::HullEvaluation& hulls);

/// The field `hulls` of a tree: null if it has none.
nlohmann::ordered_json hullsJson(const Hulls& hulls);

/// The field `hierarchy`, to and from JSON. @throws as levelFromJson().
nlohmann::ordered_json hierarchyJson(const builder::HierarchyEvaluation& hierarchy);
builder::HierarchyEvaluation hierarchyFromJson(const nlohmann::ordered_json& json);

}  // namespace spheretree::pipeline
