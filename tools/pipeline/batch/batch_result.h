// SPDX-License-Identifier: GPL-3.0-or-later
// What a batch found out: plain figures of every object, of a budget and of speed against accuracy. report.json is this
// and nothing else (schema spheretree.batch/1; every key: docs/batch.md).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/tree_figures.h"

namespace spheretree::pipeline {

enum class ItemStatus { Waiting, Built, Cached, Failed, Skipped };

/// An object of the scene or its tool.
struct ObjectResult {
  std::string name;
  bool is_tool = false;
  ItemStatus status = ItemStatus::Waiting;
  std::string error;           // of one that failed
  TreeFigures figures;         // of one that was built or cached, as everything below
  double seconds = 0;          // that its build took, now or when it came into the cache
  std::size_t saved = 0;       // leaves that its levels and branching allow but its tolerance made unnecessary
  std::size_t bytes = 0;       // of its file
  std::filesystem::path tree;  // its file, in the folder of the batch
  bool hasTree() const { return status == ItemStatus::Built || status == ItemStatus::Cached; }
};

struct Budget {
  double amount = 0;     // > 0: leaves of all trees together, or
  bool is_time = false;  // microseconds of a step, by stepModel()
};

struct BudgetRound {
  bool is_final = false;  // with the trees of the scene's own quality; else with quick ones
  std::size_t leaves = 0;
  std::optional<double> worst_ratio, model_us;
};

struct BudgetResult {
  Budget budget;
  double spent = 0;  // in the unit of the budget
  bool met = false;
  std::optional<double> worst_ratio;  // largest proven error as a multiple of its tolerance (of 1 mm without one)
  double common_ratio = 1;            // of the trees that could have more leaves
  bool has_recorded_paths = false;    // of a budget of time: the steps are those of recordings, not of random contacts
  std::vector<BudgetRound> rounds;
};

/// Costs of the steps in contact: those with a pair of leaves within the reach of the step.
struct StepCost {
  std::size_t steps = 0;
  double pairs_median = 0, pairs_p99 = 0;
  double model_us_p99 = 0;                     // stepModel() of each step: the same on every machine
  double time_us_median = 0, time_us_p99 = 0;  // processor time, the least of three runs; measured only if asked for
};

/// Speed against accuracy of the scene or of one object, for one number of leaves or one tolerance.
struct SpeedRow {
  std::optional<std::string> object;  // none: the whole scene
  std::optional<std::size_t> leaves_each;
  std::optional<double> tolerance_mm;
  bool chosen = false;  // the trees that the batch wrote; then neither leaves_each nor tolerance_mm
  std::size_t leaves = 0;
  double overhang_bound_mm = 0, overhang_max_mm = 0, overhang_mean_mm = 0;
  std::optional<std::size_t> memory_bytes;  // of the runtime; none for the tool alone
  std::optional<StepCost> cost;             // none if no step was in contact
};

struct BatchResult {
  std::string generator;
  std::filesystem::path scene;        // as it was given
  bool is_reference_named = false;    // the scene says "tip" or "centre"; not in report.json
  double tool_distance_mm = 0;        // from the tool's reference point to the nearest vertex of its mesh, or sphere of its tree
  std::vector<ObjectResult> objects;  // the tool first
  std::optional<BudgetResult> budget;
  std::optional<std::vector<SpeedRow>> speed;
  std::vector<std::string> notes;  // of a scene that was drafted from mesh files
  double seconds = 0;              // of the whole batch
  struct Times {
    double read = 0, build = 0, chart = 0, write = 0;  // [s]; build: also the search for a budget
  } times;                                             // not in report.json
};

struct BatchTotals {
  std::size_t built = 0, cached = 0, failed = 0, skipped = 0, triangles = 0, leaves = 0, saved = 0, nodes = 0, bytes = 0;
  double overhang_bound_mm = 0;  // the largest of all leaves
};

BatchTotals totalsOf(const BatchResult& result);

nlohmann::ordered_json toJson(const BatchResult& result);

/// report.json of a batch. @throws formats::FileError; formats::FormatError if it is not one of this schema.
BatchResult readBatchResult(const std::filesystem::path& path);

}  // namespace spheretree::pipeline
