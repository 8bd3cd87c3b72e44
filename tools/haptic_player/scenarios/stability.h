// SPDX-License-Identifier: GPL-3.0-or-later
// Runs scenarios in the requested modes, prints a table, and writes stability.json with the recordings and the models.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "scenarios/scenario.h"

namespace spheretree::player {

/// The scenarios that `names` selects: ids, aliases or "all", in any case. @throws std::invalid_argument; the message
/// lists the valid names.
std::vector<const Scenario*> selectScenarios(const std::string& names);

struct ScenarioResult {
  const Scenario* scenario;
  std::map<Mode, Outcome> outcomes;
  double seconds = 0;
  std::map<std::string, std::string> recordings;  // by mode: file names
};

/// Whether a figure passes; an informative figure always does.
bool holds(const Figure& figure);
bool holds(const Outcome& outcome);

/// Runs a scenario in these modes; in modes of other renderers only if it is for all. Recordings go to `ID.MODE.csv` in
/// `folder` (empty: none), with an additional column penetration_mm, and are then released from memory. @throws
/// formats::FileError
ScenarioResult runScenario(const Scenario& scenario, ScenarioContext& context, std::span<const Mode> modes,
                           const std::filesystem::path& folder);

/// The column heads, including that of the constrained mode on turned bodies; and the lines of a scenario: its title,
/// then one line for each figure.
std::string tableHead(std::span<const Mode> modes);
std::string tableRows(const ScenarioResult& result, std::span<const Mode> modes);

/// Whether the scenario passes in the constrained mode; if that was not run, in every mode.
bool holds(const ScenarioResult& result);

/// Schema spheretree.stability/1. Docs: docs/stability.md
nlohmann::ordered_json stabilityJson(const std::vector<ScenarioResult>& results, builder::Quality quality);

/// Writes `folder`/stability.json, with the content of stabilityJson(), and the bodies as .stree and .off.
/// @throws formats::FileError
void writeStability(const std::filesystem::path& folder, const std::vector<ScenarioResult>& results, builder::Quality quality);

}  // namespace spheretree::player
