// SPDX-License-Identifier: GPL-3.0-or-later
// Runs scenarios in both modes, prints a table, and writes stability.json with the recordings and the models behind
// them.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "scenarios/scenario.h"

namespace spheretree::player {

/// Those that `names` mean: ids, aliases or "all", any case. @throws std::invalid_argument that lists what there is.
std::vector<const Scenario*> selectScenarios(const std::string& names);

struct ScenarioResult {
  const Scenario* scenario;
  Outcome paper, constrained;
  double seconds = 0;
  std::map<std::string, std::string> recordings;  // by mode: names of files
};

/// Whether a figure is reached; an informative one always is.
bool holds(const Figure& figure);
bool holds(const Outcome& outcome);

/// Runs it in both modes. Recordings go to `ID.MODE.csv`, with a column penetration_mm at the end, in `folder` (empty:
/// nowhere) and out of memory. @throws formats::FileError
ScenarioResult runScenario(const Scenario& scenario, Bench& bench, const std::filesystem::path& folder);

/// Lines of the table: a scenario's title, then one line for each figure.
std::string tableRows(const ScenarioResult& result);

/// Schema spheretree.stability/1. Docs: docs/stability.md
nlohmann::ordered_json stabilityJson(const std::vector<ScenarioResult>& results, builder::Quality quality);

/// `folder`/stability.json, as stabilityJson() says, and the bodies as .stree and .off.
/// @throws formats::FileError
void writeStability(const std::filesystem::path& folder, const std::vector<ScenarioResult>& results, builder::Quality quality);

}  // namespace spheretree::player
