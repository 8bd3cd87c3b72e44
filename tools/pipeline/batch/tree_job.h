// SPDX-License-Identifier: GPL-3.0-or-later
// One tree of a batch: the part of a mesh file that it is built from, how it is built, and the result with its figures.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "pipeline/batch/mesh_store.h"
#include "pipeline/batch/tree_figures.h"
#include "pipeline/batch/work_regions.h"
#include "spheretree/builder/build_sphere_tree.h"
#include "spheretree/builder/repair_mesh.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::pipeline {

struct TreeResult {
  SphereTree tree;
  TreeFigures figures;
  double seconds = 0;  // that the build took
};

struct TreeJob {
  std::shared_ptr<const MeshStore::File> file;
  std::filesystem::path path;  // for messages
  std::string part;            // "": the whole mesh
  std::size_t triangles = 0;   // of the part
  std::string repair = "auto";
  builder::BuildSettings settings;
  Configuration pose;                       // of the object in the world
  std::shared_ptr<const WorkRegions> work;  // null: the same accuracy everywhere
  // With settings.most_leaves > 0 all of these leaves are used, and the tolerances say where: they are the scene's,
  // multiplied by
  // `scale`, and the leaves come as near to them as they can.
  double scale = 1;

  /// Hash of everything that the tree depends on: content, part, unit, settings, version of the program; 32 hexadecimal
  /// digits.
  std::string key() const;
  /// Hash of the mesh alone, as it is built; 32 hexadecimal digits.
  std::string meshKey() const;
  /// The mesh as it is built. @throws builder::BuildError if it is refused; builder::Cancelled.
  builder::RepairedMesh solid(builder::Progress& progress) const;
  /// @throws builder::BuildError, builder::Cancelled
  TreeResult run(builder::Progress& progress) const;
};

/// Names from a scene file, which its reader has checked.
builder::BuildSettings buildSettings(const formats::TreeSettings& settings);

}  // namespace spheretree::pipeline
