// SPDX-License-Identifier: GPL-3.0-or-later
// One tree of a batch: the part of a mesh file from which it is built, the settings, and the result with its figures.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/batch/tree_figures.h"
#include "pipeline/batch/work_regions.h"
#include "pipeline/mesh_store.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/repair_mesh.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {

struct TreeResult {
  SphereTree tree;
  TreeFigures figures;
  double seconds = 0;  // duration of the build
};

struct TreeJob {
  std::shared_ptr<const MeshStore::File> file;
  std::filesystem::path path;  // for messages
  std::string part;            // "": the whole mesh
  std::size_t triangles = 0;   // of the part
  std::string repair = "auto";
  builder::BuildSettings settings;
  Configuration pose;                       // of the object in the world
  std::shared_ptr<const WorkRegions> work;  // null: the same tolerance everywhere
  Eigen::AlignedBox3d world_box;            // of the input; set with `work`
  // With settings.max_leaves > 0 the tree has exactly this number of leaves. The scene's tolerances, multiplied by
  // `scale`, decide where they are; the leaves meet them as well as possible.
  double scale = 1;
  // For a budget: the tree has as few leaves as the tolerances allow after they are multiplied by `scale`. Without a
  // tolerance, `scale` is the error in mm. The skin does not depend on `scale`.
  bool is_for_error = false;

  /// Sets `work`, and the box by which its regions are selected.
  void grade(std::shared_ptr<const WorkRegions> regions);
  /// The regions of `work` that can change a tolerance of this object.
  std::vector<formats::WorkRegion> regions() const;
  /// Hash of everything on which the tree depends: content, part, unit, settings, version of the program; 32
  /// hexadecimal digits.
  std::string key() const;
  /// Hash of the mesh that is built, without the settings of the tree; 32 hexadecimal digits.
  std::string meshKey() const;
  /// The repaired mesh. @throws builder::BuildError if it is refused; builder::Cancelled.
  builder::RepairedMesh solid(builder::Progress& progress) const;
  /// @throws builder::BuildError, builder::Cancelled
  TreeResult run(builder::Progress& progress) const;
};

/// `settings`: with names from a scene file, which its reader has checked.
builder::BuildSettings buildSettings(const formats::TreeSettings& settings);

}  // namespace spheretree::pipeline
