// SPDX-License-Identifier: GPL-3.0-or-later
// Turns every object of a scene into a tree, and writes a compiled scene and a report: the implementation of
// `spheretree batch`. Output files, and how an interrupted batch continues: docs/batch.md
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

/// The scene of a batch that was started with mesh files; it is in the folder of the results.
inline constexpr const char* kDraftedScene = "drafted.scene.json";

struct BatchSettings {
  std::filesystem::path scene;   // *.scene.json; unused with `draft`
  std::filesystem::path folder;  // of the results; created if it is missing
  std::filesystem::path cache;   // of finished trees; empty: `cache` in `folder`
  Shard shard;                   // count > 1: only fills the cache, and writes nothing else
  int threads = 0;               // 0: all processors of the machine
  std::optional<Budget> budget;
  formats::TreeSettings overrides;           // override the settings of the scene for every object and the tool
  bool speed = false;                        // also measure speed against accuracy
  bool dry_run = false;                      // builds and writes nothing; objects that would be built are Skipped
  std::optional<SceneDraftSettings> draft;   // mesh files instead of `scene`; their scene becomes kDraftedScene in `folder`
  std::vector<std::filesystem::path> paths;  // trajectories or recordings, for `speed` and for a budget of time
};

/// Builds the trees that are not in the cache; writes NAME.stree for each tree, scene.json and report.json. If an
/// object fails, the others are still built, and its result has the reason. Same scene and settings (except `threads`):
/// same bytes of every tree and of scene.json. With `draft` it also writes the drafted scene, and a ball if that is the
/// tool.
/// @throws tool::UsageError for incompatible settings or an output that would replace an input; formats::FileError,
/// formats::FormatError for the scene and the paths; builder::Cancelled: finished trees are in the cache.
BatchResult runBatch(const BatchSettings& settings, tool::WorkProgress& progress);

}  // namespace spheretree::pipeline
