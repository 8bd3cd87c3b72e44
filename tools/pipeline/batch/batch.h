// SPDX-License-Identifier: GPL-3.0-or-later
// Every object of a scene to trees, with a compiled scene and a report: what `spheretree batch` calls. What it writes,
// and how it goes on after it was stopped: docs/batch.md
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "pipeline/batch/batch_items.h"
#include "pipeline/batch/batch_result.h"
#include "pipeline/scene_draft.h"
#include "spheretree/formats/scene_file.h"
#include "work_progress.h"

namespace spheretree::pipeline {

/// The scene that a batch of mesh files was made from, in the folder of its results.
inline constexpr const char* kDraftedScene = "drafted.scene.json";

struct BatchSettings {
  std::filesystem::path scene;   // *.scene.json; unused with `draft`
  std::filesystem::path folder;  // of the results; made if it is missing
  std::filesystem::path cache;   // of finished trees; empty: `cache` in `folder`
  Shard shard;                   // count > 1: only the cache is filled, and nothing else is written
  int threads = 0;               // 0: as many as the machine has
  std::optional<Budget> budget;
  formats::TreeSettings overrides;           // in place of what the scene says, for every object and the tool
  bool speed = false;                        // also measure speed against accuracy
  bool dry_run = false;                      // nothing is built or written; objects that would be built are Skipped
  std::optional<SceneDraftSettings> draft;   // in place of `scene`: mesh files; their scene becomes kDraftedScene in `folder`
  std::vector<std::filesystem::path> paths;  // trajectories or recordings whose steps `speed` and a budget of time count
};

/// Builds what the cache does not hold; writes NAME.stree for each tree, scene.json and report.json. An object that
/// fails does not stop the others: its result says why. Same scene and settings (threads aside): same bytes of every
/// tree and of scene.json. With `draft` also the drafted scene and a ball, if that is the tool.
/// @throws tool::UsageError for settings that do not go together or an output that would replace an input;
/// formats::FileError, formats::FormatError for the scene and the paths; builder::Cancelled: finished trees are in the
/// cache.
BatchResult runBatch(const BatchSettings& settings, tool::WorkProgress& progress);

}  // namespace spheretree::pipeline
