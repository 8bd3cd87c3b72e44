// SPDX-License-Identifier: GPL-3.0-or-later
// Many patients in one run: processes this shard's share of a cohort, patient by patient; each scene is built as by
// `batch`. Output files, and how an interrupted run continues: docs/cohorts.md
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/batch/batch.h"
#include "spheretree/formats/cohort_list.h"

namespace spheretree::pipeline {

/// The result of a patient, the worst last.
enum class PatientState { Ok, Missed, Failed, Refused };

struct PatientResult {
  std::string name;
  PatientState state = PatientState::Ok;
  std::string error;  // reason why its scene was refused, or why its first failed object failed
  std::size_t built = 0, cached = 0, failed = 0, missed = 0, leaves = 0;
  std::optional<double> worst_ratio;  // largest proven overhang as a multiple of its tolerance
  std::string worst_object;           // the object with this ratio
  double work = 0;                    // estimatedWork() of the scene
  double seconds = 0;
};

struct CohortSettings {
  std::filesystem::path list, folder;
  std::filesystem::path cache;  // shared by all patients; empty: `cache` in `folder`
  Shard shard;                  // whole patients, distributed by estimated work
  int threads = 0;
  formats::TreeSettings overrides;
};

/// Estimated duration of a scene, in units of an object with a small mesh: an object counts 1, plus 1 for each 4 MB of
/// its mesh file. The size of a file that several objects use is divided among them. A scene that cannot be read counts
/// 1.
double estimatedWork(const std::filesystem::path& scene);

/// The shard (from 1) of each patient: in the order of decreasing work, each patient goes to the shard with the least
/// work so far; ties go to the lower index. The result is at most 4/3 of the optimum: R. L. Graham. Bounds on
/// multiprocessing timing anomalies. SIAM J. Appl. Math. 17, 1969.
std::vector<std::size_t> shareOut(const std::vector<double>& work, std::size_t shards);

/// Builds this shard's patients into `folder`/NAME and calls `tell` after each. Its log, cohort.I-of-N.jsonl, has a
/// line for each finished patient. If a patient fails, the others are still processed. Same list and settings: same
/// bytes of every tree and scene.json, for any number of shards.
/// @throws tool::UsageError, formats::FileError, formats::FormatError for the list; builder::Cancelled: finished trees
/// are in the cache.
std::vector<PatientResult> runCohort(const CohortSettings& settings, tool::WorkProgress& progress,
                                     const std::function<void(const PatientResult&, std::size_t done, std::size_t of)>& tell);

/// A line of the log. Schema spheretree.cohort/1: docs/cohorts.md
nlohmann::ordered_json toJson(const PatientResult& result);

/// Reads the logs in the folder of a cohort. If a patient has several lines, the line in the most recently written log
/// counts. Worst first: by state, then by ratio, then by name.
/// @throws formats::FileError if there is no log; formats::FormatError for a line that is not a valid log entry.
std::vector<PatientResult> readCohortLogs(const std::filesystem::path& folder);

const char* nameOf(PatientState state);

}  // namespace spheretree::pipeline
