// SPDX-License-Identifier: GPL-3.0-or-later
// Runs scenarios in the requested modes, prints a table, and writes stability.json with the recordings and the models.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "scenarios/scenario.h"
#include "work_progress.h"

namespace spheretree::player {

/// The scenarios that `names` selects: ids, aliases or "all", in any case. @throws std::invalid_argument; the message
/// lists the valid names.
std::vector<const Scenario*> selectScenarios(const std::string& names);

struct ScenarioResult {
  const Scenario* scenario;
  std::map<Mode, Outcome> outcomes;
  double seconds = 0;                             // the sum over the modes
  std::map<std::string, std::string> recordings;  // by mode: file names
};

/// Whether a figure passes; an informative figure always does.
bool holds(const Figure& figure);
bool holds(const Outcome& outcome);

struct RunSettings {
  std::vector<Mode> modes;
  std::filesystem::path folder{};  // for recordings; empty: none
  int threads = 1;
};

/// Runs scenarios in these modes; in modes of other renderers only those that are for all. The scenarios and modes are
/// independent of one another, and apart from times, results do not depend on the number of threads. Recordings go to
/// `ID.MODE.csv` in the folder, with an additional column penetration_mm, and are then released from memory. `tell` is
/// called with each result, in the order of the scenarios. @throws formats::FileError, builder::Cancelled
std::vector<ScenarioResult> runScenarios(std::span<const Scenario* const> scenarios, const ScenarioContext& context,
                                         const RunSettings& settings, tool::WorkProgress& progress,
                                         const std::function<void(const ScenarioResult&)>& tell = {});

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
