// SPDX-License-Identifier: GPL-3.0-or-later
// The results of a batch: figures of every object, of a budget and of speed against accuracy. They are the whole
// content of report.json (schema spheretree.batch/1; every key: docs/batch.md).
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/tree_figures.h"

namespace spheretree::pipeline {

enum class ItemStatus { Waiting, Built, Cached, Failed, Skipped };

/// The tool, or an object of the scene.
struct ObjectResult {
  std::string name;
  bool is_tool = false;
  ItemStatus status = ItemStatus::Waiting;
  std::string error;           // reason, if it failed
  TreeFigures figures;         // of a tree that was built or cached, as all members below
  double seconds = 0;          // duration of its build, now or when it was cached
  std::size_t saved = 0;       // leaves that its levels and branching allow, but that its tolerance did not need
  std::size_t bytes = 0;       // size of its file
  std::filesystem::path tree;  // its file, relative to the folder of the batch
  bool hasTree() const { return status == ItemStatus::Built || status == ItemStatus::Cached; }
};

struct Budget {
  double amount = 0;     // > 0: number of leaves of all trees together, or
  bool is_time = false;  // microseconds of a step, by stepModel()
};

struct BudgetRound {
  bool is_final = false;  // the trees have the scene's own quality; false: quick
  std::size_t leaves = 0;
  std::optional<double> worst_ratio, model_us;
};

struct BudgetResult {
  Budget budget;
  double spent = 0;  // in the unit of the budget
  bool met = false;
  std::optional<double> worst_ratio;  // largest proven overhang as a multiple of its tolerance (of 1 mm without one)
  double common_ratio = 1;            // ratio of all trees that could have more leaves
  bool has_recorded_paths = false;    // of a budget of time: the steps are those of recordings; false: random contacts
  std::vector<BudgetRound> rounds;
};

/// Costs of the steps in contact: steps with a pair of leaves within the margin.
struct StepCost {
  std::size_t steps = 0;
  double pairs_median = 0, pairs_p99 = 0;
  double model_us_p99 = 0;                     // stepModel() of each step: the same on every machine
  double time_us_median = 0, time_us_p99 = 0;  // processor time, the smallest of three runs; measured only on request
};

/// Speed against accuracy of the scene or of one object, for one number of leaves or one tolerance.
struct SpeedRow {
  std::optional<std::string> object;  // empty: the whole scene
  std::optional<std::size_t> leaves_each;
  std::optional<double> tolerance_mm;
  bool chosen = false;  // the trees that the batch wrote; leaves_each and tolerance_mm are then empty
  std::size_t leaves = 0;
  double overhang_bound_mm = 0, overhang_max_mm = 0, overhang_mean_mm = 0;
  std::optional<std::size_t> memory_bytes;  // of the runtime; empty for the tool alone
  std::optional<StepCost> cost;             // empty if no step was in contact
};

struct BatchResult {
  std::string generator;
  std::filesystem::path scene;        // as given by the user
  bool is_reference_named = false;    // the scene specifies "tip" or "centre"; not in report.json
  double tool_distance_mm = 0;        // distance from the tool's reference point to the nearest vertex of its mesh, or sphere of its tree
  std::vector<ObjectResult> objects;  // the tool is first
  std::optional<BudgetResult> budget;
  std::optional<std::vector<SpeedRow>> speed;
  std::vector<std::string> notes;  // on a scene that was drafted from mesh files
  double seconds = 0;              // of the whole batch
  struct Times {
    double read = 0, build = 0, chart = 0, write = 0;  // [s]; `build` includes the search for a budget
  } times;                                             // not in report.json
};

struct BatchTotals {
  std::size_t built = 0, cached = 0, failed = 0, skipped = 0, triangles = 0, leaves = 0, saved = 0, nodes = 0, bytes = 0;
  double overhang_bound_mm = 0;  // largest overhang bound of all leaves
};

BatchTotals totalsOf(const BatchResult& result);

nlohmann::ordered_json toJson(const BatchResult& result);

/// Reads the report.json of a batch. @throws formats::FileError; formats::FormatError if it does not have this schema.
BatchResult readBatchResult(const std::filesystem::path& path);

}  // namespace spheretree::pipeline
