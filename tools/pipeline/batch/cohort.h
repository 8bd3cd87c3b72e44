// SPDX-License-Identifier: GPL-3.0-or-later
// Many patients in one run: the share of a cohort that is this shard's, patient by patient, each as `batch` builds its
// scene. What it writes, and how it goes on after it was stopped: docs/cohorts.md
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

/// What came of a patient, worst last.
enum class PatientState { Ok, Missed, Failed, Refused };

struct PatientResult {
  std::string name;
  PatientState state = PatientState::Ok;
  std::string error;  // of one whose scene was refused, or of the first object that failed
  std::size_t built = 0, cached = 0, failed = 0, missed = 0, leaves = 0;
  std::optional<double> worst_ratio;  // largest proven overhang as a multiple of its tolerance
  std::string worst_object;           // that has it
  double work = 0;                    // estimatedWork() of the scene
  double seconds = 0;
};

struct CohortSettings {
  std::filesystem::path list, folder;
  std::filesystem::path cache;  // of all patients; empty: `cache` in `folder`
  Shard shard;                  // whole patients, shared out by estimated work
  int threads = 0;
  formats::TreeSettings overrides;
};

/// How long a scene takes, in objects of a small mesh: an object counts 1, and 1 more for each 4 MB of its mesh file.
/// A file that several objects share is shared among them. A scene that cannot be read counts 1.
double estimatedWork(const std::filesystem::path& scene);

/// Shard (from 1) of each patient: the next largest goes to the shard with the least work so far; ties to the lower
/// index. At most 4/3 of the best: R. L. Graham. Bounds on multiprocessing timing anomalies. SIAM J. Appl. Math. 17,
/// 1969.
std::vector<std::size_t> shareOut(const std::vector<double>& work, std::size_t shards);

/// Builds this shard's patients into `folder`/NAME and calls `tell` after each. Its log, cohort.I-of-N.jsonl, has a
/// line for each patient that is done. One that fails does not stop the others. Same list and settings: same bytes of
/// every tree and scene.json, for any number of shards.
/// @throws tool::UsageError, formats::FileError, formats::FormatError for the list; builder::Cancelled: finished trees
/// are in the cache.
std::vector<PatientResult> runCohort(const CohortSettings& settings, tool::WorkProgress& progress,
                                     const std::function<void(const PatientResult&, std::size_t done, std::size_t of)>& tell);

/// A line of the log, and back. Schema spheretree.cohort/1: docs/cohorts.md
nlohmann::ordered_json toJson(const PatientResult& result);

/// The logs in the folder of a cohort; of a patient with several lines, the one of the log that was written last
/// counts. Worst first: by state, then by ratio, then by name.
/// @throws formats::FileError if there is none; formats::FormatError for a line that is none of a log.
std::vector<PatientResult> readCohortLogs(const std::filesystem::path& folder);

const char* nameOf(PatientState state);

}  // namespace spheretree::pipeline
