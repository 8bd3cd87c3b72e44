// SPDX-License-Identifier: GPL-3.0-or-later
// Runs scenarios in the modes that are asked for, prints a table, and writes stability.json with the recordings and the
// models behind them.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "scenarios/scenario.h"

namespace spheretree::player {

/// Those that `names` mean: ids, aliases or "all", any case. @throws std::invalid_argument that lists what there is.
std::vector<const Scenario*> selectScenarios(const std::string& names);

struct ScenarioResult {
  const Scenario* scenario;
  std::map<Mode, Outcome> outcomes;
  double seconds = 0;
  std::map<std::string, std::string> recordings;  // by mode: names of files
};

/// Whether a figure is reached; an informative one always is.
bool holds(const Figure& figure);
bool holds(const Outcome& outcome);

/// Runs it in these modes; in those that are not ours only if it is for all. Recordings go to `ID.MODE.csv`, with a
/// column penetration_mm at the end, in `folder` (empty: nowhere) and out of memory. @throws formats::FileError
ScenarioResult runScenario(const Scenario& scenario, ScenarioContext& context, std::span<const Mode> modes,
                           const std::filesystem::path& folder);

/// The heads of the columns, that of the constrained mode on turned bodies among them, and the lines of a scenario: its
/// title, then one line for each figure.
std::string tableHead(std::span<const Mode> modes);
std::string tableRows(const ScenarioResult& result, std::span<const Mode> modes);

/// Whether the constrained mode, or if it was not asked for every mode, holds.
bool holds(const ScenarioResult& result);

/// Schema spheretree.stability/1. Docs: docs/stability.md
nlohmann::ordered_json stabilityJson(const std::vector<ScenarioResult>& results, builder::Quality quality);

/// `folder`/stability.json, as stabilityJson() says, and the bodies as .stree and .off.
/// @throws formats::FileError
void writeStability(const std::filesystem::path& folder, const std::vector<ScenarioResult>& results, builder::Quality quality);

}  // namespace spheretree::player
