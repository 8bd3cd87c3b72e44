// SPDX-License-Identifier: GPL-3.0-or-later
// Scenes in the format of report.js: a tool, placed objects, recordings to replay.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "page/page.h"
#include "spheretree/builder/progress.h"
#include "spheretree/core/sphere_tree.h"
#include "spheretree/core/triangle_mesh.h"
#include "spheretree/formats/scene_file.h"

namespace spheretree::tool {

/// Collects models; each is stored once, however often it is shown. data.root["models"]: {NAME: {tree, mesh}}.
struct ShownMesh {
  TriangleMesh mesh, to_cover;  // as repaired: repair_mesh.h
};

class ModelStore {
 public:
  /// `triangles`: number of triangles of a mesh in the page.
  ModelStore(PageData& data, std::size_t triangles) : data_(data), triangles_(triangles) { data.root["models"] = Json::object(); }
  /// Adds the tree, and the mesh if there is one. Returns the name of the model; an earlier one if the trees have the
  /// same bytes.
  std::string add(const std::string& name, const std::filesystem::path& tree, const ShownMesh* mesh);
  /// Adds a tree in memory.
  void add(const std::string& name, const SphereTree& tree, const ShownMesh* mesh);

 private:
  PageData& data_;
  std::size_t triangles_;
  std::map<std::string, std::string> name_of_;  // by the hash of the tree's file
};

/// The meshes of a compiled scene, which its source scene names, by the names of the items. Meshes that can no longer
/// be read are absent. Items with the same mesh share it.
using ShownMeshes = std::map<std::string, std::shared_ptr<const ShownMesh>>;
ShownMeshes meshesOf(const std::filesystem::path& source_scene, builder::Progress& progress);

/// The JSON of a scene of trees: {name, tool: {model, reference_point_mm}, objects: [{name, model, position_mm,
/// quaternion_wxyz}], replays: []}; adds its models. @throws the exceptions of the readers.
Json sceneForView(const formats::SceneFile& scene, const std::filesystem::path& file, const ShownMeshes& meshes, ModelStore& models);

}  // namespace spheretree::tool
