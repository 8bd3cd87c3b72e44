// SPDX-License-Identifier: GPL-3.0-or-later
// The tool and the objects of a scene while they are turned into trees: they are read, looked up in the cache, and
// built by all threads under one progress bar.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/batch/batch_result.h"
#include "pipeline/batch/tree_cache.h"
#include "pipeline/batch/tree_job.h"
#include "spheretree/formats/scene_file.h"
#include "work_progress.h"

namespace spheretree::pipeline {

/// The tool (first), an object, or a layer within an object that a burr cuts.
struct BatchItem {
  /// Of a layer: its own source, and the object that it belongs to.
  std::shared_ptr<const formats::SceneItem> layer;
  const formats::SceneItem* object = nullptr;
  const formats::SceneItem* source = nullptr;
  bool is_tool = false;
  TreeJob job;
  std::string key;  // "": the item came as a tree
  ItemStatus status = ItemStatus::Waiting;
  std::string error;            // why the item failed
  TreeResult result;            // set when the item is built or cached
  std::vector<std::byte> soft;  // content of the .soft file, for soft tissue
  /// Its file name in the folder of the batch.
  std::string treeName() const { return source->name + (source->soft ? ".soft" : ".stree"); }
  bool hasTree() const { return status == ItemStatus::Built || status == ItemStatus::Cached; }
};

/// Part I of N of the trees to build.
struct Shard {
  std::size_t index = 1, count = 1;
};

/// The data that every step of a batch uses.
struct BatchContext {
  const formats::SceneFile& scene;
  const TreeCache& cache;
  int threads;
  tool::WorkProgress& progress;
  std::shared_ptr<WorkRegions> work;  // null: the scene has neither regions of work nor `reach`
  bool tell_finished = false;         // report each built object with progress.finished()
};

/// The name of a layer as an item.
std::string layerName(const formats::SceneItem& object, const formats::CutLayer& layer);

/// The items of `scene`, which must outlive them, the layers last, with their meshes (kept in `meshes`) or their trees.
/// An item that cannot be read has the status Failed.
/// @throws builder::Cancelled
std::vector<BatchItem> loadItems(const formats::SceneFile& scene, const std::filesystem::path& scene_path, MeshStore& meshes, int threads,
                                 builder::Progress& progress);

/// The largest number of leaves of an item for which the program chooses the number: from the levels in the scene, or
/// else that of the deepest tree.
std::size_t maxLeaves(const formats::SceneFile& scene, const BatchItem& item);

/// Limits the number of leaves, in the shallowest tree that can have them.
void limitLeaves(builder::BuildSettings& settings, std::size_t leaves);

/// Gives the objects the regions of work and the reach of the scene; null if the scene has none.
std::shared_ptr<WorkRegions> assignWorkRegions(const formats::SceneFile& scene, std::vector<BatchItem>& items);

/// Sentences about regions of work that change nothing: those that touch no object, and objects in a region, or in a
/// scene with a reach, whose settings use neither. `work` may be null.
std::vector<std::string> notesOnWork(const WorkRegions* work, const std::vector<BatchItem>& items);

/// Every waiting item gets its key and its tree, from the cache or by a build, the largest mesh first. Of identical
/// items only one is built. Items that are neither in this `shard` nor in the cache are skipped. `stage`: name for the
/// progress bar. If an item fails, the others are still built.
/// @throws builder::Cancelled; formats::FileError if something has to be built and the cache is not writable.
void buildItems(std::vector<BatchItem>& items, const BatchContext& context, const std::string& stage, const Shard& shard = {});

}  // namespace spheretree::pipeline
