// SPDX-License-Identifier: GPL-3.0-or-later
// The tool and the objects of a scene on their way to trees: read, looked up in the cache, built by all threads under
// one progress bar.
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

/// The tool (first) or an object.
struct BatchItem {
  const formats::SceneItem* source = nullptr;
  bool is_tool = false;
  TreeJob job;
  std::string key;  // "": it came as a tree
  ItemStatus status = ItemStatus::Waiting;
  std::string error;            // why it failed
  TreeResult result;            // once it is built or cached
  std::vector<std::byte> soft;  // of the .soft file, of soft tissue
  /// Of its file in the folder of the batch.
  std::string treeName() const { return source->name + (source->soft ? ".soft" : ".stree"); }
  bool hasTree() const { return status == ItemStatus::Built || status == ItemStatus::Cached; }
};

/// The I-th of N shares of what is to be built.
struct Shard {
  std::size_t index = 1, count = 1;
};

/// What every step of a batch works with.
struct BatchContext {
  const formats::SceneFile& scene;
  const TreeCache& cache;
  int threads;
  tool::WorkProgress& progress;
  std::shared_ptr<WorkRegions> work;  // null: the scene says nothing of where accuracy is needed
  bool tell_finished = false;         // each object that was built, by progress.finished()
};

/// The items of `scene`, which must outlive them: their meshes, which `meshes` holds, or their trees. One that cannot
/// be read has failed.
/// @throws builder::Cancelled
std::vector<BatchItem> loadItems(const formats::SceneFile& scene, const std::filesystem::path& scene_path, MeshStore& meshes, int threads,
                                 builder::Progress& progress);

/// The most leaves that an item may have where their number is chosen for it: what the scene says of its levels, or the
/// deepest tree.
std::size_t mostLeaves(const formats::SceneFile& scene, const BatchItem& item);

/// At most this many leaves, in the shallowest tree that holds them.
void limitLeaves(builder::BuildSettings& settings, std::size_t leaves);

/// Gives the objects what the scene says about where accuracy is needed; null if it says nothing.
std::shared_ptr<WorkRegions> assignWorkRegions(const formats::SceneFile& scene, std::vector<BatchItem>& items);

/// Every waiting item gets its key and its tree: from the cache, or built, the biggest first. Of identical items one is
/// built. Those that are not in this `shard` and not in the cache are skipped. `stage` is what the progress bar says.
/// One bad item does not stop the others.
/// @throws builder::Cancelled; formats::FileError if something is to be built and the cache cannot be written to.
void buildItems(std::vector<BatchItem>& items, const BatchContext& context, const std::string& stage, const Shard& shard = {});

}  // namespace spheretree::pipeline
